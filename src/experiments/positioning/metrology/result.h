#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/experiments/positioning/metrology/qualification.h"

/// A qualification as others read it.
namespace cosiva::experiments {

/// What the runs were, for whoever wants to have them again.
struct Conditions {
  std::string command;                                        ///< the command line
  std::string what;                                           ///< "virtual time on lacet4", "recordings"
  std::vector<std::pair<std::string, std::string>> settings;  ///< name and value, in words
  std::vector<std::string> notes;                             ///< what its reader should know
  std::vector<std::vector<Point2>> lines{};  ///< of the zone, to be drawn beneath ways; none in the open
};

/// One JSON document: `algorithms[]` with name, rmse_m, mean_m, variance_m2, precision and the rest, `comparisons[]`,
/// `ranks`, `conditions`, `digest`. Numbers that there are none of are null.
[[nodiscard]] std::string to_json(const Qualification& qualification, const Conditions& conditions);
/// A few lines for a terminal.
[[nodiscard]] std::string to_text(const Qualification& qualification);
/// One HTML page that needs nothing else.
[[nodiscard]] std::string to_html(const Qualification& qualification, const Conditions& conditions);
/// algorithm,run,rmse_m,mean_m,variance_m2,precision,max_m,nees: a line per vote.
[[nodiscard]] std::string to_csv(const Qualification& qualification);

/// What evo's evo_res opens: a zip with info.json, stats.json, error_array.npy and timestamps.npy, uncompressed.
/// @param errors_m  of one run
/// @param alignment  that they are after
[[nodiscard]] std::string evo_zip(std::string_view title, const std::vector<double>& times_s,
                                  const std::vector<double>& errors_m, Alignment alignment = Alignment::none);

}  // namespace cosiva::experiments
