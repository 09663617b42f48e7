#include "cosiva/app/resources/vehicle_file.h"

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "target.h"

/// A vehicle file that is accepted makes options that read back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto catalogue = app::read_vehicle_file(fuzz::as_text(data, size), "fuzz.toml");
  if (!catalogue) {
    COSIVA_EXPECT(!catalogue.error().code.empty() && !catalogue.error().message.empty());
    COSIVA_EXPECT(catalogue.error().location.starts_with("fuzz.toml"));
    return 0;
  }
  JsonWriter json;
  aiv::write_json(json, *catalogue);
  const auto parsed = JsonValue::parse(json.text());
  COSIVA_EXPECT(parsed);
  const auto again = aiv::action_catalogue_from_json(*parsed);
  COSIVA_EXPECT(again && again->types.size() == catalogue->types.size());
  COSIVA_EXPECT(again->load_positions == catalogue->load_positions);
  return 0;
}
