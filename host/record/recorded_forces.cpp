#include "host/record/recorded_forces.hpp"

#include <array>

#include "host/backends/words.hpp"
#include "host/steppers/joint_source.hpp"
#include "host/steppers/reported_contacts.hpp"

namespace lockstep {

namespace {

void store(const Eigen::Vector3d& vector, double (&out)[3]) {
  for (int k = 0; k < 3; ++k) out[k] = vector[k];
}

template <class real>
std::vector<ContactForceRow> contact_forces(Simulation<real>& simulation) {
  Backend<real>& backend = simulation.backend();
  const Buffer shapes[] = {Buffer::shape_infos};
  const std::vector<ShapeInfo> infos = backend.download(shapes).shape_infos;
  const double time = impulse_time(simulation.params(), backend.features());
  std::vector<ContactForceRow> rows;
  for (const StepContact& contact : step_contacts(backend, simulation.params(), simulation.counters(), infos)) {
    ContactForceRow row = {contact.body_a, contact.body_b, contact.shape_a, contact.shape_b, contact.geometry.gap()};
    store(contact.geometry.point(), row.point);
    store(contact.geometry.normal, row.normal);
    store(contact.impulse / time, row.force);
    rows.push_back(row);
  }
  return rows;
}

template <class real>
std::vector<JointForceRow> joint_forces(Simulation<real>& simulation) {
  const JointSources<real> sources(simulation.backend(), simulation.has_stepped());
  std::vector<JointForceRow> rows(sources.count());
  for (u32 joint = 0; joint < rows.size(); ++joint) {
    const JointSource<real> source = sources.of(joint);
    const JointMeasures measures = measure_joint(source.buffers, simulation.params(), joint, source.impulses);
    store(measures.force, rows[joint].force);
    store(measures.torque, rows[joint].torque);
    rows[joint].drive = measures.drive;
  }
  return rows;
}

std::string in_words(const char* table, std::size_t row, const char* column, const std::string& recorded,
                     const std::string& here) {
  return std::string(table) + "[" + std::to_string(row) + "] " + column + ": recorded " + recorded + ", here " + here;
}

// Of columns of double that lie one behind the other.
struct Column {
  const char* name;
  int count;
};

std::optional<std::string> row_difference(const char* table, std::size_t row, std::initializer_list<Column> columns,
                                          const double* recorded, const double* here) {
  for (const Column& column : columns)
    for (int k = 0; k < column.count; ++k, ++recorded, ++here)
      if (!same_bits(*recorded, *here))
        return in_words(table, row, column.name, show_word(*recorded), show_word(*here));
  return {};
}

std::optional<std::string> row_difference(std::size_t row, const ContactForceRow& recorded,
                                          const ContactForceRow& here) {
  const auto members = [](const ContactForceRow& of) {
    return std::array{of.body_a, of.body_b, of.shape_a, of.shape_b};
  };
  const std::array was = members(recorded), is = members(here);
  const char* const names[] = {"body_a", "body_b", "shape_a", "shape_b"};
  for (std::size_t k = 0; k < was.size(); ++k)
    if (was[k] != is[k])
      return in_words("contact_forces", row, names[k], std::to_string(was[k]), std::to_string(is[k]));
  return row_difference("contact_forces", row, {{"gap", 1}, {"point", 3}, {"normal", 3}, {"force", 3}}, &recorded.gap,
                        &here.gap);
}

std::optional<std::string> row_difference(std::size_t row, const JointForceRow& recorded, const JointForceRow& here) {
  return row_difference("joint_forces", row, {{"force", 3}, {"torque", 3}, {"drive", 1}}, recorded.force, here.force);
}

template <class Row>
std::optional<std::string> table_difference(const char* table, const std::vector<Row>& recorded,
                                            const std::vector<Row>& here) {
  if (recorded.size() != here.size())
    return std::string(table) + ": recorded are " + std::to_string(recorded.size()) + " rows, here " +
           std::to_string(here.size());
  for (std::size_t row = 0; row < here.size(); ++row)
    if (const auto found = row_difference(row, recorded[row], here[row])) return found;
  return {};
}

}  // namespace

std::optional<std::string> difference(const RecordedForces& recorded, const RecordedForces& here) {
  const auto found = table_difference("contact_forces", recorded.contacts, here.contacts);
  return found ? found : table_difference("joint_forces", recorded.joints, here.joints);
}

template <class real>
RecordedForces recorded_forces(Simulation<real>& simulation) {
  const Features features = simulation.backend().features();
  RecordedForces forces;
  if (has(features, Feature::contacts)) forces.contacts = contact_forces(simulation);
  if (has(features, Feature::joints)) forces.joints = joint_forces(simulation);
  return forces;
}

template RecordedForces recorded_forces(Simulation<float>&);
template RecordedForces recorded_forces(Simulation<double>&);

}  // namespace lockstep
