#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"

/// The reference's own uncertainty, part by part.
namespace cosiva::experiments {

struct ReferencePart {
  std::string name;                     ///< "floor fit"
  std::optional<double> uncertainty_m;  ///< standard; nothing where not given yet
  std::string source;                   ///< origin of the value
};

struct ReferenceBudget {
  std::vector<ReferencePart> parts;  ///< independent of each other

  /// u: the root of the sum of squares of the given parts.
  [[nodiscard]] double total_m() const;
  /// The part of u², in percent; 0 for a part that is not given.
  [[nodiscard]] double ratio_percent(const ReferencePart& part) const;
  /// Number of parts that are not given: u is more than the total then.
  [[nodiscard]] std::size_t untold() const;
};

/// A camera H above the floor displaces a tag of height h away from its foot by h/(H − h) of their distance; an error
/// of h leaves a residual after this is corrected: ρ·δh/(H − h).
[[nodiscard]] double height_uncertainty_m(double from_foot_m, double height_error_m, double tag_height_m,
                                          double camera_height_m);

/// The file: {"format": "cosiva.reference_budget.v1", "parts": [{"name", "source", and one of
///   "uncertainty_m" (null: not given yet);
///   "time_s" and "speed_mps": v·τ;
///   "height_error_m", "tag_height_m", "camera_height_m" and "from_foot_m"}]}. Fails ("reference.budget") with the
/// part and the field.
[[nodiscard]] Result<ReferenceBudget> read_reference_budget(std::string_view text, const std::string& file);
[[nodiscard]] std::string to_json(const ReferenceBudget& budget);
/// Writes the fields into an open object: uncertainty_m, untold, parts[] with name, uncertainty_m, ratio_percent,
/// source.
void write_fields(JsonWriter& json, const ReferenceBudget& budget);
/// "u 1.30 mm: floor fit 0.95, time stamp 0.25; not given: mounting".
[[nodiscard]] std::string text_of(const ReferenceBudget& budget);

/// RMSE of the algorithm alone, with the reference's part removed; 0 where the reference explains it completely.
[[nodiscard]] double without_reference_m(double rmse_detected_m, double reference_m);

inline constexpr std::string_view reference_budget_format = "cosiva.reference_budget.v1";

}  // namespace cosiva::experiments
