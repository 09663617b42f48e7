#include "cosiva/wire/vda5050/factsheet.h"

#include <algorithm>
#include <array>

#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/wire/vda5050/json_in.h"
#include "cosiva/wire/vda5050/json_out.h"
#include "cosiva/wire/vda5050/terms.h"
#include "cosiva/wire/vda5050/write_header.h"

namespace cosiva::wire::vda5050 {
namespace {

constexpr std::array<std::string_view, 3> kinematics{"DIFF", "OMNI", "THREEWHEEL"};
constexpr std::array<std::string_view, 4> classes{"FORKLIFT", "CONVEYOR", "TUGGER", "CARRIER"};
constexpr std::array<std::string_view, 7> value_types{"BOOL",   "NUMBER", "INTEGER", "FLOAT",
                                                      "STRING", "OBJECT", "ARRAY"};

template <std::size_t N>
std::string_view one_of(const std::array<std::string_view, N>& terms, std::string_view word,
                        std::string_view otherwise) {
  return std::ranges::find(terms, word) == terms.end() ? otherwise : word;
}

std::string_view value_type(const ParameterValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return one_of(value_types, text == nullptr ? std::string_view{} : std::string_view{*text}, "STRING");
}

void write_physical(JsonOut& out, const Factsheet& sheet) {
  out.key(R"("physicalParameters":)").open('{');
  out.field(R"("speedMin":)", sheet.speed_min_mps).field(R"("speedMax":)", sheet.speed_max_mps);
  out.field(R"("accelerationMax":)", sheet.acceleration_max_mps2);
  out.field(R"("decelerationMax":)", sheet.deceleration_max_mps2);
  out.field(R"("heightMin":)", sheet.height_m).field(R"("heightMax":)", sheet.height_m);
  out.field(R"("width":)", sheet.width_m).field(R"("length":)", sheet.length_m).close('}');
}

void write_limits(JsonOut& out, const Factsheet& sheet) {
  const auto bytes = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
  out.key(R"("protocolLimits":)").open('{');
  out.key(R"("maxStringLens":)").open('{').field(R"("msgLen":)", bytes(payload_bytes_max));
  out.field(R"("topicSerialLen":)", 64U).field(R"("idLen":)", bytes(text_bytes_max)).close('}');
  out.key(R"("maxArrayLens":)").open('{');
  for (const std::string_view key : {R"("order.nodes":)", R"("order.edges":)", R"("node.actions":)",
                                     R"("edge.actions":)", R"("actions.actionsParameters":)", R"("instantActions":)"})
    out.field(key, bytes(array_items_max));
  out.close('}');
  out.key(R"("timing":)").open('{');
  out.field(R"("minOrderInterval":)", sheet.min_order_interval_s);
  out.field(R"("minStateInterval":)", sheet.min_state_interval_s);
  out.field(R"("defaultStateInterval":)", sheet.default_state_interval_s);
  out.field(R"("visualizationInterval":)", sheet.visualization_interval_s).close('}').close('}');
}

void write_parameter(JsonOut& out, const Parameter& parameter, bool optional) {
  out.open('{').field(R"("key":)", parameter.key).field(R"("valueDataType":)", value_type(parameter.value));
  if (optional) out.field(R"("isOptional":)", true);
  out.close('}');
}

void write_supported_action(JsonOut& out, const Factsheet::SupportedAction& action) {
  out.open('{').field(R"("actionType":)", action.type).text_if_any(R"("actionDescription":)", action.description);
  out.key(R"("actionScopes":)").open('[');
  if (action.instant) out.value("INSTANT");
  if (action.node) out.value("NODE");
  if (action.edge) out.value("EDGE");
  out.close(']');
  if (!action.parameters.empty() || !action.optional_parameters.empty()) {
    out.key(R"("actionParameters":)").open('[');
    for (const Parameter& parameter : action.parameters) write_parameter(out, parameter, false);
    for (const Parameter& parameter : action.optional_parameters) write_parameter(out, parameter, true);
    out.close(']');
  }
  if (!action.blocking_types.empty()) {
    out.array(R"("blockingTypes":)", action.blocking_types,
              [&](BlockingType type) { out.value(text_of(blocking_types, type)); });
  }
  out.close('}');
}

struct DeclaredParameter {
  Parameter parameter;
  bool optional{false};
};

void read_supported_action(Fields& fields, Factsheet::SupportedAction& action) {
  fields.text("actionType", action.type, Need::required);
  fields.description("actionDescription", action.description);
  fields.each_text("actionScopes", [&](std::string_view scope) {
    action.instant = action.instant || scope == "INSTANT";
    action.node = action.node || scope == "NODE";
    action.edge = action.edge || scope == "EDGE";
  });
  std::vector<DeclaredParameter> declared;
  fields.each("actionParameters", Need::optional, declared, [](Fields& item, DeclaredParameter& read) {
    std::string type{"STRING"};
    item.text("key", read.parameter.key, Need::required);
    item.text("valueDataType", type, Need::optional);
    item.flag("isOptional", read.optional, Need::optional);
    read.parameter.value = std::move(type);
  });
  for (DeclaredParameter& read : declared)
    (read.optional ? action.optional_parameters : action.parameters).push_back(std::move(read.parameter));
  fields.each_text("blockingTypes", [&](std::string_view text) {
    if (const auto type = value_of(blocking_types, text)) action.blocking_types.push_back(*type);
  });
}

}  // namespace

std::string encode(const Factsheet& message) {
  JsonOut out{2048};
  out.open('{');
  write_header(out, message.header);
  out.key(R"("typeSpecification":)").open('{').field(R"("seriesName":)", message.series_name);
  out.text_if_any(R"("seriesDescription":)", message.series_description);
  out.field(R"("agvKinematic":)", one_of(kinematics, message.agv_kinematic, "DIFF"));
  out.field(R"("agvClass":)", one_of(classes, message.agv_class, "CARRIER")).field(R"("maxLoadMass":)", 0U);
  out.raw(R"("localizationTypes":["RFID","SPOT"])").raw(R"("navigationTypes":["PHYSICAL_LINE_GUIDED"])").close('}');
  write_physical(out, message);
  write_limits(out, message);
  out.key(R"("protocolFeatures":)").open('{').raw(R"("optionalParameters":[])");
  out.array(R"("agvActions":)", message.actions,
            [&](const Factsheet::SupportedAction& action) { write_supported_action(out, action); });
  out.close('}').raw(R"("agvGeometry":{})").key(R"("loadSpecification":)").open('{');
  if (!message.load_positions.empty()) {
    out.array(R"("loadPositions":)", message.load_positions, [&](const std::string& position) { out.value(position); });
  }
  out.close('}').close('}');
  return out.take();
}

Result<Factsheet> decode_factsheet(std::string_view json) {
  // Peers send half-empty factsheets until they are configured: the fields that are present are read.
  return decode_message<Factsheet>(json, "factsheet", [](Fields& fields, Factsheet& sheet) {
    read_header(fields, sheet.header, Need::optional);
    fields.object("typeSpecification", Need::optional, [&](Fields& type) {
      type.text("seriesName", sheet.series_name, Need::optional);
      type.description("seriesDescription", sheet.series_description);
      type.text("agvKinematic", sheet.agv_kinematic, Need::optional);
      type.text("agvClass", sheet.agv_class, Need::optional);
    });
    fields.object("physicalParameters", Need::optional, [&](Fields& physical) {
      physical.number("speedMin", sheet.speed_min_mps, Need::optional);
      physical.number("speedMax", sheet.speed_max_mps, Need::optional);
      physical.number("accelerationMax", sheet.acceleration_max_mps2, Need::optional);
      physical.number("decelerationMax", sheet.deceleration_max_mps2, Need::optional);
      physical.number("heightMax", sheet.height_m, Need::optional);
      physical.number("width", sheet.width_m, Need::optional);
      physical.number("length", sheet.length_m, Need::optional);
    });
    fields.object("protocolLimits", Need::optional, [&](Fields& limits) {
      limits.object("timing", Need::optional, [&](Fields& timing) {
        timing.number("minOrderInterval", sheet.min_order_interval_s, Need::optional);
        timing.number("minStateInterval", sheet.min_state_interval_s, Need::optional);
        timing.number("defaultStateInterval", sheet.default_state_interval_s, Need::optional);
        timing.number("visualizationInterval", sheet.visualization_interval_s, Need::optional);
      });
    });
    fields.object("protocolFeatures", Need::optional, [&](Fields& features) {
      features.each("agvActions", Need::optional, sheet.actions, read_supported_action);
    });
    fields.object("loadSpecification", Need::optional, [&](Fields& loads) {
      loads.each_text("loadPositions", [&](std::string_view position) { sheet.load_positions.emplace_back(position); });
    });
  });
}

}  // namespace cosiva::wire::vda5050
