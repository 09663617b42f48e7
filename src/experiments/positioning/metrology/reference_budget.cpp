#include "cosiva/experiments/positioning/metrology/reference_budget.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

/// Larger errors of a reference are implausible.
constexpr double biggest_m = 1e3;

/// Reads one part's fields, and records the first invalid one.
class PartReader {
 public:
  PartReader(const JsonValue& json, std::string location) : json_{json}, location_{std::move(location)} {}

  [[nodiscard]] bool has(std::string_view key) const { return json_.find(key) != nullptr; }
  double number(std::string_view key, double most) {
    const auto value = json_.number(key);
    if (value && *value >= 0.0 && *value <= most) return *value;
    record(key, "expected a number from 0 to " + readable(most));
    return 0.0;
  }
  std::string text(std::string_view key) {
    auto value = json_.text(key);
    if (!value || value->empty()) record(key, "expected a text");
    return std::string(value.value_or(""));
  }
  void record(std::string_view key, const std::string& message) {
    if (!error_) error_ = Error{"reference.budget", message, location_ + ": '" + std::string(key) + "'"};
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const JsonValue& json_;
  std::string location_;
  std::optional<Error> error_;
};

std::optional<double> uncertainty_of(PartReader& part, const JsonValue& json) {
  const std::array kinds{part.has("uncertainty_m"), part.has("time_s"), part.has("height_error_m")};
  if (std::ranges::count(kinds, true) != 1) {
    part.record("uncertainty_m",
                "expected one of uncertainty_m, time_s (with speed_mps) and height_error_m (with tag_height_m, "
                "camera_height_m, from_foot_m)");
    return std::nullopt;
  }
  if (kinds[0]) {
    if (json.find("uncertainty_m")->is_null()) return std::nullopt;
    return part.number("uncertainty_m", biggest_m);
  }
  if (kinds[1]) return part.number("time_s", biggest_m) * part.number("speed_mps", biggest_m);
  const double tag_m = part.number("tag_height_m", biggest_m);
  const double camera_m = part.number("camera_height_m", biggest_m);
  const double error_m = part.number("height_error_m", biggest_m);
  const double from_foot_m = part.number("from_foot_m", biggest_m);
  if (!(camera_m > tag_m)) {
    part.record("camera_height_m", "the camera hangs above the tag");
    return std::nullopt;
  }
  return height_uncertainty_m(from_foot_m, error_m, tag_m, camera_m);
}

std::string mm(double metres) { return readable(1e3 * metres, 2); }

}  // namespace

double ReferenceBudget::total_m() const {
  double squares = 0.0;
  for (const ReferencePart& part : parts) {
    const double u = part.uncertainty_m.value_or(0.0);
    squares += u * u;
  }
  return std::sqrt(squares);
}

double ReferenceBudget::ratio_percent(const ReferencePart& part) const {
  const double all = total_m();
  const double ratio = all > 0.0 ? part.uncertainty_m.value_or(0.0) / all : 0.0;
  return 100.0 * ratio * ratio;
}

std::size_t ReferenceBudget::untold() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(parts, [](const ReferencePart& part) { return !part.uncertainty_m; }));
}

double height_uncertainty_m(double from_foot_m, double height_error_m, double tag_height_m, double camera_height_m) {
  return from_foot_m * height_error_m / (camera_height_m - tag_height_m);
}

Result<ReferenceBudget> read_reference_budget(std::string_view text, const std::string& file) {
  const auto json = JsonValue::parse(text);
  if (!json) return fail("reference.budget", json.error().message, file);
  if (json->object() == nullptr || json->text("format") != reference_budget_format)
    return fail("reference.budget",
                "expected a JSON object with \"format\": \"" + std::string(reference_budget_format) + "\"", file);
  const JsonValue* parts = json->find("parts");
  if (parts == nullptr || parts->array() == nullptr || parts->array()->empty())
    return fail("reference.budget", "expected a list of parts", file + ": 'parts'");
  ReferenceBudget budget;
  for (const JsonValue& one : *parts->array()) {
    const std::string location = file + ": part " + std::to_string(budget.parts.size() + 1);
    if (one.object() == nullptr) return fail("reference.budget", "expected an object", location);
    PartReader reader{one, location};
    ReferencePart part;
    part.name = reader.text("name");
    part.source = reader.text("source");
    part.uncertainty_m = uncertainty_of(reader, one);
    if (reader.error()) return tl::unexpected(*reader.error());
    // A repeated part would count twice.
    if (std::ranges::find(budget.parts, part.name, &ReferencePart::name) != budget.parts.end())
      return fail("reference.budget", "'" + part.name + "' is given twice", location);
    budget.parts.push_back(std::move(part));
  }
  return budget;
}

std::string to_json(const ReferenceBudget& budget) {
  JsonWriter json{2};
  json.begin_object().field("format", reference_budget_format);
  write_fields(json, budget);
  json.end_object();
  return json.take() + "\n";
}

void write_fields(JsonWriter& json, const ReferenceBudget& budget) {
  json.field("uncertainty_m", budget.total_m()).field("untold", budget.untold()).key("parts").begin_array();
  for (const ReferencePart& part : budget.parts) {
    json.begin_object().field("name", part.name).key("uncertainty_m");
    if (part.uncertainty_m)
      json.value(*part.uncertainty_m);
    else
      json.null();
    json.field("percent", budget.ratio_percent(part)).field("source", part.source).end_object();
  }
  json.end_array();
}

std::string text_of(const ReferenceBudget& budget) {
  std::string inputs;
  std::string untold;
  for (const ReferencePart& part : budget.parts) {
    std::string& list = part.uncertainty_m ? inputs : untold;
    list += (list.empty() ? "" : ", ") + part.name;
    if (part.uncertainty_m) list += " " + mm(*part.uncertainty_m);
  }
  return "u " + mm(budget.total_m()) + " mm" + (inputs.empty() ? "" : ": " + inputs) +
         (untold.empty() ? "" : "; not given: " + untold);
}

double without_reference_m(double rmse_detected_m, double reference_m) {
  return std::sqrt(std::fmax(0.0, rmse_detected_m * rmse_detected_m - reference_m * reference_m));
}

}  // namespace cosiva::experiments
