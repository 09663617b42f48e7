#include "cosiva/zone/layout/circuit_factory.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/zone/drawing/zone_circuit.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

const ZoneConfiguration with_sidecar{"lif", "site.lif.json", "the file", "the sidecar"};

/// A read-only format, whose files are valid when their text is "good".
class Rigid final : public CircuitFactory {
 public:
  [[nodiscard]] std::string_view format() const override { return "rigid"; }
  [[nodiscard]] std::vector<std::string_view> file_endings() const override { return {".rigid"}; }
  [[nodiscard]] Result<TrafficZone> make_zone(const ZoneConfiguration& configuration) const override {
    if (configuration.text != "good") return fail("rigid.bad", "expected good", "line 1");
    return testing::lacet4();
  }
  [[nodiscard]] Result<std::shared_ptr<const DrawableCircuit>> make_circuit(
      const ZoneConfiguration& configuration) const override {
    return circuit_of(make_zone(configuration));
  }
};

TEST(CircuitFactory, by_default_writes_nothing_and_edits_nothing) {
  std::vector<Diagnostic> lost;
  const auto written = Rigid{}.written(testing::lacet4(), lost);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, "zone.write");
  EXPECT_EQ(written.error().message, "zones are read from 'rigid', but not written to it");
  const auto edited = Rigid{}.edited({"rigid", "site.rigid", "good"}, {});
  ASSERT_FALSE(edited);
  EXPECT_EQ(edited.error().code, "edit.format");
  EXPECT_EQ(edited.error().location, "site.rigid");
}

TEST(CircuitFactory, by_default_reports_the_fault_of_make_zone_alone) {
  EXPECT_TRUE(Rigid{}.faults({"rigid", "x", "good"}).empty());
  const auto faults = Rigid{}.faults({"rigid", "x", "bad"});
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, "rigid.bad");
  EXPECT_EQ(faults[0].location, "line 1");
}

TEST(ZoneConfiguration, has_the_same_content_wherever_it_comes_from) {
  ZoneConfiguration other = with_sidecar;
  other.origin = "topic";
  EXPECT_TRUE(same_content(with_sidecar, other));
  EXPECT_EQ(version_of(with_sidecar), version_of(other));
  for (std::string ZoneConfiguration::*const field :
       {&ZoneConfiguration::format, &ZoneConfiguration::text, &ZoneConfiguration::sidecar}) {
    other = with_sidecar;
    other.*field += "x";
    EXPECT_FALSE(same_content(with_sidecar, other));
    EXPECT_NE(version_of(with_sidecar), version_of(other));
  }
  EXPECT_EQ(version_of(with_sidecar).size(), 16U);
  // What moves from the file to the sidecar file makes another map.
  EXPECT_NE(version_of({"lif", "", "ab", "c"}), version_of({"lif", "", "b", "ca"}));
}

TEST(ZoneConfiguration, is_sent_as_its_file_or_as_sidecar_zero_byte_and_file) {
  EXPECT_EQ(to_payload({"toml", "a.toml", "text"}), "text");
  EXPECT_EQ(to_payload(with_sidecar), std::string("the sidecar\0the file", 20));
  for (const ZoneConfiguration& configuration : {with_sidecar, ZoneConfiguration{"toml", "a.toml", "text"}})
    EXPECT_EQ(from_payload(configuration.format, configuration.origin, to_payload(configuration)), configuration);
  EXPECT_EQ(from_payload("lif", "t", std::string("\0file", 5)).text, "file");
}

TEST(ZoneConfiguration, is_read_from_its_json) {
  for (const ZoneConfiguration& configuration : {with_sidecar, ZoneConfiguration{"toml", "a.toml", "text"}}) {
    JsonWriter json;
    write_json(json, configuration);
    ASSERT_TRUE(json.complete());
    const auto value = JsonValue::parse(json.text());
    ASSERT_TRUE(value);
    EXPECT_EQ(value->find("sidecar") != nullptr, !configuration.sidecar.empty());
    const auto read = zone_configuration_from_json(*value);
    ASSERT_TRUE(read);
    EXPECT_EQ(*read, configuration);
  }
  EXPECT_EQ(zone_configuration_from_json(*JsonValue::parse(R"({"format":"toml","text":"t"})"))->origin, "");
  for (const char* bad : {"[]", "3", R"({"format":"toml"})", R"({"text":"t"})", R"({"format":1,"text":"t"})"}) {
    const auto read = zone_configuration_from_json(*JsonValue::parse(bad));
    ASSERT_FALSE(read) << bad;
    EXPECT_EQ(read.error().code, "zone.configuration");
  }
}

}  // namespace
}  // namespace cosiva::zone
