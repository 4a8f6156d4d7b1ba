#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "host/app/bench_results.hpp"

namespace lockstep::app {

namespace {

constexpr const char* head = R"(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Lockstep: speed against error</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1, h2 { line-height: 1.2; font-weight: 600; }
h2 { margin-top: 3rem; border-bottom: 1px solid #ddd; padding-bottom: .3rem; }
svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-size: .85rem; }
th, td { padding: .2rem .7rem; text-align: right; border-bottom: 1px solid #eee; white-space: nowrap; }
th { font-weight: 600; border-bottom-color: #999; vertical-align: bottom; white-space: normal; }
td:first-child, th:first-child, td.failed, td.word { text-align: left; }
td.failed { color: #a02010; white-space: normal; }
.wide { overflow-x: auto; }
summary { cursor: pointer; margin: .5rem 0; }
a { color: #0b6fa4; }
</style>
</head>
<body>
)";

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      default: result += c;
    }
  }
  return result;
}

// Without the prologue, which has no place within a page.
std::string inlined(const std::string& svg) {
  const std::size_t start = svg.find("<svg");
  return start == std::string::npos ? "" : svg.substr(start);
}

std::string row_of(const BenchTrial& t, std::size_t quantities) {
  std::string row =
      fmt::format("<tr><td>{}</td><td>{}</td><td>{:.4g}</td><td>{}</td><td>{}</td><td>{:.3g}</td><td>{:.3g}</td>",
                  escaped(t.method), t.precision, t.dt, t.substeps, t.sweeps ? std::to_string(*t.sweeps) : "",
                  t.ms_per_step, t.ms_per_second());
  if (!t.failure.empty())
    return row + fmt::format("<td class=\"failed\" colspan=\"{}\">{}</td></tr>\n", quantities + 1, escaped(t.failure));
  for (const CaseError& e : t.errors) row += fmt::format("<td>{:.3g}</td>", e.error);
  return row + fmt::format("<td>{}</td></tr>\n", t.residual ? fmt::format("{:.2g}", *t.residual) : "");
}

std::string in_words(const CaseError& e) {
  return escaped(e.quantity) + (e.unit.empty() ? "" : ", " + escaped(e.unit));
}

// A table for each device.
std::string tables_of(const BenchCase& benched) {
  std::vector<std::string> devices;
  for (const BenchTrial& t : benched.trials)
    if (std::ranges::find(devices, t.device) == devices.end()) devices.push_back(t.device);
  const std::span<const CaseError> quantities = benched.quantities();
  std::string text;
  for (const std::string& device : devices) {
    text += fmt::format(
        "<p>{}</p>\n<div class=\"wide\"><table>\n<tr><th>method</th><th>precision</th><th>dt, s</th><th>sub-steps</th>"
        "<th>sweeps</th><th>ms a step</th><th>ms a second</th>",
        escaped(device));
    for (const CaseError& e : quantities) text += fmt::format("<th>{}</th>", in_words(e));
    text += "<th>residual</th></tr>\n";
    for (const BenchTrial& t : benched.trials)
      if (t.device == device) text += row_of(t, quantities.size());
    text += "</table></div>\n";
  }
  return text;
}

// What came closest in a precision, and at what cost.
std::string closest(const BenchCase& benched, const std::string& precision) {
  const BenchTrial* best = nullptr;
  for (const BenchTrial& t : benched.trials)
    if (t.precision == precision && !t.errors.empty() && (!best || t.errors[0].error < best->errors[0].error))
      best = &t;
  if (best == nullptr) return "<td></td><td></td><td></td>";
  return fmt::format("<td>{:.2g}</td><td>{:.3g}</td><td class=\"word\">{}</td>", best->errors[0].error,
                     best->ms_per_second(), escaped(best->method));
}

std::string overview(const std::vector<BenchCase>& cases) {
  std::string text =
      "<div class=\"wide\"><table>\n<tr><th>case</th><th>quantity</th><th>least error, float</th><th>ms a second</th>"
      "<th>by</th><th>least error, double</th><th>ms a second</th><th>by</th></tr>\n";
  for (const BenchCase& benched : cases) {
    const std::string quantity = benched.quantities().empty() ? "" : in_words(benched.quantities()[0]);
    text += fmt::format("<tr><td><a href=\"#{0}\">{0}</a></td><td class=\"word\">{1}</td>{2}{3}</tr>\n",
                        escaped(benched.name), quantity, closest(benched, "float"), closest(benched, "double"));
  }
  return text + "</table></div>\n";
}

}  // namespace

std::string to_html(const std::vector<BenchCase>& cases, const std::vector<std::string>& plots,
                    const std::string& machine) {
  std::string page = head;
  page += fmt::format(
      "<h1>Speed against error</h1>\n<p>Hard cases with exact answers (<code>lockstep bench</code>), computed by {}. "
      "Down "
      "and to the left is better: the error of the first quantity of the table, over the wall time that a second of "
      "simulated time takes. Times are medians over the steps of a run; errors are those of every device that is "
      "bit-exact."
      "</p>\n",
      escaped(machine));
  page += overview(cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    page += fmt::format(
        "<h2 id=\"{0}\">{0}</h2>\n<p>{1}.</p>\n{2}\n<details{3}><summary>Figures</summary>\n{4}</details>\n",
        escaped(cases[i].name), escaped(cases[i].says), inlined(plots[i]), plots[i].empty() ? " open" : "",
        tables_of(cases[i]));
  }
  return page + "</body>\n</html>\n";
}

}  // namespace lockstep::app
