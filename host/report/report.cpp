#include "host/report/report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/world_hash.hpp"

namespace lockstep {

namespace {

using Json = nlohmann::ordered_json;

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json stage_times(const Report& report) {
  Json json = Json::object();
  for (const auto& [stage, ms] : report.stage_ms) json[stage] = ms;
  return json;
}

Json steps_by_plan(const Report& report) {
  if (report.steps_by_plan.empty()) return nullptr;
  Json json = Json::object();
  for (const auto& [plan, steps] : report.steps_by_plan) json[plan] = steps;
  return json;
}

Json worst_contact(const Report& report) {
  if (!report.worst) return nullptr;
  const WorstContact& at = *report.worst;
  const auto id = [](u32 value) { return value == NONE ? Json(nullptr) : Json(value); };
  const auto name = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  return {{"step", report.worst_step},           {"world", at.world},        {"body_a", id(at.body_a)},
          {"name_a", name(report.worst_name_a)}, {"body_b", id(at.body_b)},  {"name_b", name(report.worst_name_b)},
          {"shape_a", id(at.shape_a)},           {"shape_b", id(at.shape_b)}};
}

std::string body_text(u32 id, const std::string& name) {
  if (id == NONE) return "the world";
  return name.empty() ? fmt::format("body {}", id) : fmt::format("body \"{}\"", name);
}

std::string row(const std::string& label, const std::string& value) {
  return fmt::format("  {:<26}{}\n", label, value);
}

// A figure with its unit, or nothing where it does not apply.
std::string error_row(const std::string& label, const std::optional<double>& value, const std::string& unit) {
  return value ? row(label, fmt::format("{:.3g}{}", *value, unit)) : "";
}

constexpr const char* event_keys[EVENT_KINDS] = {"contact_begins", "contact_ends", "trigger_enters", "trigger_leaves",
                                                 "impacts"};

std::string event_row(const Report& report) {
  if (!report.events) return "";
  const auto& [begins, ends, enters, leaves, impacts] = *report.events;
  std::string text = fmt::format("{} began, {} ended", begins, ends);
  if (enters + leaves > 0) text += fmt::format("; triggers: {} entered, {} left", enters, leaves);
  if (impacts > 0) text += fmt::format("; impacts: {}", impacts);
  return row("touches", text);
}

std::string stage_rows(const Report& report) {
  double sum = 0;
  for (const auto& [stage, ms] : report.stage_ms) sum += ms;
  std::string text;
  for (const auto& [stage, ms] : report.stage_ms) {
    text += row("  " + stage, fmt::format("{:.4f} ms  {:.1f} %", ms, 100 * ms / sum));
  }
  return text;
}

std::string contact_rows(const Report& report) {
  std::string text;
  if (report.contacts_max > 0 || report.max_penetration_m > 0)
    text += row("penetration max, mean",
                fmt::format("{:.3g} mm, {:.3g} mm", 1e3 * report.max_penetration_m, 1e3 * report.mean_penetration_m));
  if (report.residual_median)
    text += row("residual median, max", fmt::format("{:.3g}, {:.3g}  (rounding: {:.1g})", *report.residual_median,
                                                    *report.residual_max, *report.residual_floor));
  if (report.particles)
    text += row("particles", fmt::format("{:.0f}, centres within {:.3g} mm, inertias within {:.3g}", *report.particles,
                                         1e3 * *report.particle_center_error_m, *report.particle_inertia_error));
  if (report.model_error)
    text += row("model error",
                fmt::format("{:.3g}  (of another model of friction than cones by Coulomb)", *report.model_error));
  if (report.defect_velocity_max.value_or(0) > 0)
    text += row("worst defect",
                fmt::format("{:.3g} m/s in step {} between {} and {} of world {}", *report.defect_velocity_max,
                            report.worst_step, body_text(report.worst->body_a, report.worst_name_a),
                            body_text(report.worst->body_b, report.worst_name_b), report.worst->world));
  return text;
}

Json verdict_json(const Verdict& verdict) {
  Json json = {{"good", verdict.good()}, {"in_words", in_words(verdict)}};
  for (u32 i = 0; i < criterion_count; ++i) {
    const Criterion criterion = static_cast<Criterion>(i);
    const Judgement& j = verdict[criterion];
    const bool judged = verdict.is_judged(criterion);
    json[info(criterion).name] = {{"worst", j.worst},
                                  {"bound", judged ? Json(j.bound) : Json(nullptr)},
                                  {"worst_step", j.worst_step},
                                  {"first_step", verdict.keeps(criterion) ? Json(nullptr) : Json(j.first_step)}};
  }
  const std::string source = in_words(verdict.energy_source);
  json["not_judged_because"] = source.empty() ? Json(nullptr) : Json(source);
  return json;
}

std::string verdict_rows(const Verdict& verdict) {
  const std::string source = in_words(verdict.energy_source);
  std::string text = row("verdict", (verdict.good() ? "" : "bad: ") + in_words(verdict)), figures;
  for (u32 i = 0; i < criterion_count; ++i) {
    const Criterion criterion = static_cast<Criterion>(i);
    const Judgement& j = verdict[criterion];
    if (j.worst == 0 || !verdict.is_judged(criterion)) continue;
    figures += fmt::format("{}{} {:.3g}", figures.empty() ? "" : ", ", title(criterion), j.worst);
    figures += fmt::format(" of {:.3g}{}{}", j.bound, *info(criterion).unit ? " " : "", info(criterion).unit);
  }
  if (!figures.empty()) text += row("", figures);
  if (!source.empty())
    text += row("", (verdict.is_judged(Criterion::overlap) ? "gain of energy not judged: "
                                                           : "overlap and gain of energy not judged: ") +
                        source);
  return text;
}

// How many sub-steps ended in each way that is not solved, and which was the first.
Json unsolved_ends(const Report& report) {
  const Unsolved& unsolved = report.verdict.unsolved;
  if (unsolved.count == 0) return nullptr;
  Json json = {{"first_step", unsolved.first_step}, {"first_stop", stop_name(unsolved.first_stop)}};
  for (u32 stop = 1; stop < stop_count; ++stop)
    json[std::string(stop_name(static_cast<Stop>(stop)))] = unsolved.ended[stop];
  return json;
}

// The worst sub-step that was left unsolved.
Json unsolved_worst(const Report& report) {
  const Unsolved& unsolved = report.verdict.unsolved;
  if (unsolved.count == 0) return nullptr;
  return {{"step", unsolved.worst_step},
          {"residual", unsolved.of_changes ? Json(nullptr) : Json(unsolved.worst_residual)},
          {"stop", stop_name(unsolved.worst_stop)}};
}

const char* unit_of(SensorKind kind) { return kind == SensorKind::torque ? "N m" : "N"; }

Json sensors_json(const Report& report) {
  Json json = Json::object();
  for (const SensorReading& sensor : report.sensors)
    json[sensor.name] = {{"kind", name_of(sensor.kind)}, {"unit", unit_of(sensor.kind)}, {"values", sensor.values}};
  return json;
}

std::string sensor_rows(const Report& report) {
  std::string text;
  for (const SensorReading& sensor : report.sensors) {
    std::string values;
    for (const double value : sensor.values) values += fmt::format("{}{:.6g}", values.empty() ? "" : ", ", value);
    text += row("  " + sensor.name, fmt::format("{} {} {}", name_of(sensor.kind), values, unit_of(sensor.kind)));
  }
  return text.empty() ? text : "  sensors, of the last step\n" + text;
}

Json shape_tolerances(const Report& report) {
  Json json = Json::object();
  for (const ShapeTolerance& tolerance : report.shape_tolerances) {
    json[tolerance.name] = {{"given", number_or_null(tolerance.given)},
                            {"share_of_radius", tolerance.given ? Json(nullptr) : Json(tolerance.share)}};
  }
  return json;
}

}  // namespace

double Report::body_steps_per_second() const {
  const bool alone = steps < 2;
  const double ms = alone ? ms_total : ms_total - ms_first_step;
  return ms > 0 ? 1e3 * bodies * (alone ? steps : steps - 1) / ms : 0;
}

std::string to_json(const Report& report) {
  Json json = {{"scene", report.scene},
               {"device", report.device},
               {"bit_exact", report.bit_exact},
               {"precision", report.precision},
               {"solver", report.solver},
               {"joint_solver", report.joint_solver},
               {"friction_model", report.friction_model},
               {"ranks", report.ranks},
               {"worlds", report.worlds},
               {"bodies", report.bodies},
               {"joints", report.joints},
               {"first_step", report.first_step},
               {"steps", report.steps},
               {"interrupted", report.interrupted},
               {"dt", report.dt},
               {"substeps", report.substeps},
               {"iterations", report.iterations},
               {"tolerance", report.tolerance},
               {"shape_tolerances", shape_tolerances(report)},
               {"contacts_max", report.contacts_max},
               {"steps_redone", report.steps_redone},
               {"steps_measured", report.steps_measured},
               {"ms_per_step_median", report.ms_per_step_median},
               {"ms_per_step_p99", report.ms_per_step_p99},
               {"ms_first_step", report.ms_first_step},
               {"ms_total", report.ms_total},
               {"body_steps_per_second", report.body_steps_per_second()},
               {"sweeps_median", number_or_null(report.sweeps_median)},
               {"sweeps_max", number_or_null(report.sweeps_max)},
               {"stage_ms", stage_times(report)},
               {"steps_by_plan", steps_by_plan(report)},
               {"max_penetration_m", report.max_penetration_m},
               {"mean_penetration_m", report.mean_penetration_m},
               {"residual_median", number_or_null(report.residual_median)},
               {"residual_max", number_or_null(report.residual_max)},
               {"residual_floor", number_or_null(report.residual_floor)},
               {"natural_map_max", number_or_null(report.natural_map_max)},
               {"defect_velocity_max", number_or_null(report.defect_velocity_max)},
               {"worst_contact", worst_contact(report)},
               {"joint_drift_max_m", number_or_null(report.joint_drift_max_m)},
               {"joint_angle_max_rad", number_or_null(report.joint_angle_max_rad)},
               {"energy_initial_j", report.energy_initial_j},
               {"energy_final_j", report.energy_final_j},
               {"energy_error", number_or_null(report.energy_error)},
               {"momentum_error", number_or_null(report.momentum_error)},
               {"model_error", number_or_null(report.model_error)},
               {"particles", number_or_null(report.particles)},
               {"particle_center_error_m", number_or_null(report.particle_center_error_m)},
               {"particle_inertia_error", number_or_null(report.particle_inertia_error)},
               {"asleep", number_or_null(report.asleep)},
               {"islands_asleep", number_or_null(report.islands_asleep)},
               {"wakings", number_or_null(report.wakings)},
               {"verdict", verdict_json(report.verdict)},
               {"unsolved_substeps", report.has_tolerance ? Json(report.verdict.unsolved.count) : Json(nullptr)},
               {"unsolved_ends", unsolved_ends(report)},
               {"unsolved_worst", unsolved_worst(report)},
               {"state_hash", hash_text(report.state_hash)},
               {"pose_hash", hash_text(report.pose_hash)}};
  json["sensors"] = report.sensors.empty() ? Json(nullptr) : sensors_json(report);
  json["world_state_hashes"] = Json::array();
  for (const std::uint64_t hash : report.world_state_hashes) json["world_state_hashes"].push_back(hash_text(hash));
  for (u32 kind = 0; kind < EVENT_KINDS; ++kind)
    json[event_keys[kind]] = report.events ? Json((*report.events)[kind]) : Json(nullptr);
  return json.dump(2) + "\n";
}

std::string to_table(const Report& report) {
  const std::string ranks = report.ranks > 1 ? fmt::format(" on {} ranks", report.ranks) : "";
  const std::string worlds =
      report.worlds > 1 || report.ranks > 1 ? fmt::format(" {} worlds{},", report.worlds, ranks) : "";
  std::string text = fmt::format("{} on {}, {},{} {} bodies, {} steps of {:g} ms\n", report.scene, report.device,
                                 report.precision, worlds, report.bodies, report.steps, 1e3 * report.dt);
  if (report.first_step > 0) text += fmt::format("from a checkpoint after {} steps\n", report.first_step);
  if (report.interrupted) text += "interrupted: the steps that were asked for are not all done\n";
  if (!report.bit_exact) text += fmt::format("the canary says: {}\n", report.canary);
  text += "speed\n";
  text += row("ms a step median, p99", fmt::format("{:.4g}, {:.4g}  (first {:.4g})", report.ms_per_step_median,
                                                   report.ms_per_step_p99, report.ms_first_step));
  const double simulated = report.dt * report.steps;
  text += row("simulated / wall time", fmt::format("{:.3g} s / {:.3g} s", simulated, 1e-3 * report.ms_total));
  if (!worlds.empty()) text += row("body steps a second", fmt::format("{:.4g}", report.body_steps_per_second()));
  if (report.sweeps_median)
    text += row("sweeps a step median, max", fmt::format("{}, {}  (at most {})", *report.sweeps_median,
                                                         *report.sweeps_max, report.substeps * report.iterations));
  text += stage_rows(report);
  text += fmt::format("error ({} of {} steps measured)\n", report.steps_measured, report.steps);
  if (report.contacts_max > 0) text += row("contacts at most", fmt::format("{}", report.contacts_max));
  text += contact_rows(report);
  text += event_row(report);
  if (report.asleep)
    text += row("asleep at the end", fmt::format("{:.0f} bodies in {:.0f} islands; {:.0f} steps woke some",
                                                 *report.asleep, *report.islands_asleep, *report.wakings));
  text += error_row(report.joints > 0 ? "joint drift" : "pivot drift", report.joint_drift_max_m, " m");
  if (report.joints > 0) text += error_row("joint angle error", report.joint_angle_max_rad, " rad");
  text += row("energy first, last", fmt::format("{:.6g} J, {:.6g} J", report.energy_initial_j, report.energy_final_j));
  text += error_row("energy error", report.energy_error, " of the kinetic energy");
  text += error_row("momentum error", report.momentum_error, " of the momentum");
  text += verdict_rows(report.verdict);
  text += sensor_rows(report);
  text += row("state hash, pose hash", hash_text(report.state_hash) + ", " + hash_text(report.pose_hash));
  return text;
}

}  // namespace lockstep
