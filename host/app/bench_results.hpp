// What `lockstep bench` found, and the files that say so: a table, an object and a page with plots.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/cases/hard_case.hpp"

namespace lockstep::app {

struct BenchTrial {
  std::string device = {}, precision = {}, method = {};
  double dt = 0;  // s, of a whole step
  u32 substeps = 0;
  std::optional<u32> sweeps = {};       // of a sub-step; none where nothing is solved, or by an oracle
  double ms_per_step = 0;               // median
  std::size_t steps = 0;                // timed
  std::optional<double> residual = {};  // median, where there are contacts or joints
  std::vector<CaseError> errors = {};   // empty where the trial failed
  std::string failure = {};

  /// What a second of simulated time costs, ms: what settings of different steps have in common.
  double ms_per_second() const { return ms_per_step / dt; }
};

struct BenchCase {
  std::string name, says;
  std::vector<BenchTrial> trials;

  /// What is compared, as any trial has it that did not fail; the first is the one to plot.
  std::span<const CaseError> quantities() const;
};

/// A line for each quantity of a trial, one for a trial that failed.
std::string csv_header();
std::string to_csv(const BenchCase& benched, const BenchTrial& trial);

/// An object of a trial, and the trial of such an object, the same but for quotients.
nlohmann::ordered_json to_json(const BenchTrial& trial);
BenchTrial trial_of(const nlohmann::json& object);
std::string to_json(const std::vector<BenchCase>& cases);

/// Whether gnuplot is here to plot.
bool can_plot();

/// Writes the plot of a case as SVG, by gnuplot: error over cost, a line for each method, precision and device. Returns
/// false and writes nothing where nothing can be drawn on axes of powers of ten. Throws Error (device) where gnuplot
/// fails.
bool write_plot(const BenchCase& benched, const std::string& path);

/// A page that needs no other file: for each case its plot (SVG, by case, may be empty) and its figures. `machine`: a
/// line on what computed.
std::string to_html(const std::vector<BenchCase>& cases, const std::vector<std::string>& plots,
                    const std::string& machine);

}  // namespace lockstep::app
