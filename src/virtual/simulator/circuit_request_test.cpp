#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "cosiva/virtual/simulator/simulator.h"
#include "cosiva/zone/drawing/zone_circuit.h"

namespace cosiva::virtual_side {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using zone::DrawableCircuit;
using zone::ZoneConfiguration;

zone::TrafficZone lane(std::string name) {
  auto section = zone::Section::make({}, 2.0);
  auto circuit = zone::Circuit::make(name, {{"lane", *section, std::nullopt, {}}});
  return {std::move(name), std::move(*circuit), {}, {}, {}, {}, {}, {}, {}, {}};
}

/// The circuit of a lane that counts how often it is requested to draw itself, and draws one disc.
class CountingCircuit final : public DrawableCircuit {
 public:
  explicit CountingCircuit(std::string name)
      : zone_{std::make_shared<const zone::TrafficZone>(lane(std::move(name)))} {}
  const std::shared_ptr<const zone::TrafficZone>& zone() const override { return zone_; }
  std::vector<zone::Primitive> draw() const override {
    ++drawn;
    return {{zone::Primitive::Shape::disc, "label", {{0.25, 0.5}}, 0.1, "drawn by itself"}};
  }

  mutable int drawn{0};

 private:
  std::shared_ptr<const zone::TrafficZone> zone_;
};

/// A format whose factory counts the circuits that it makes; the text "none" has none.
class CountingFactory final : public zone::CircuitFactory {
 public:
  std::string_view format() const override { return "counted"; }
  std::vector<std::string_view> file_endings() const override { return {".counted"}; }
  Result<zone::TrafficZone> make_zone(const ZoneConfiguration& /*configuration*/) const override {
    return fail("test.zone", "the simulator requests circuits, not zones");
  }
  Result<std::shared_ptr<const DrawableCircuit>> make_circuit(const ZoneConfiguration& configuration) const override {
    ++requested;
    if (configuration.text == "none") return fail("test.none", "no circuit");
    made = std::make_shared<const CountingCircuit>(configuration.text);
    return made;
  }

  mutable int requested{0};
  mutable std::shared_ptr<const CountingCircuit> made;
};

/// A simulator that receives zones of the counting factory, and the kinds of its steps.
struct Receiving {
  CountingFactory factory;
  Simulator simulator{BijectionContract{}};
  std::vector<std::string> steps;

  Result<Simulator::Reception> receive(const std::string& text) {
    const ZoneConfiguration configuration{"counted", "test.counted", text};
    auto rtm = zone::Rtm::initialise(configuration, factory);
    Result<std::shared_ptr<const zone::Rtm>> built = fail("", "");
    if (rtm)
      built = std::make_shared<const zone::Rtm>(std::move(*rtm));
    else
      built = tl::unexpected(rtm.error());
    std::ignore = simulator.build(configuration, built);
    return simulator.receive(
        virtual_epoch, configuration,
        [this](std::string_view from, std::string_view to, std::string_view kind, std::string_view /*content*/) {
          steps.push_back(std::string(from) + ">" + std::string(to) + " " + std::string(kind));
        });
  }
};

TEST(CircuitRequest, goes_from_the_rtm_to_the_factory_to_the_circuit_which_draws_itself) {
  Receiving receiving;
  ASSERT_EQ(receiving.receive("yard"), Simulator::Reception::new_zone);
  EXPECT_EQ(receiving.factory.requested, 1) << "the one circuit is prepared, and then handed over";
  ASSERT_NE(receiving.factory.made, nullptr);
  EXPECT_EQ(receiving.factory.made->drawn, 1);
  EXPECT_EQ(receiving.simulator.zone(), receiving.factory.made->zone());
  EXPECT_THAT(receiving.simulator.drawing().json, HasSubstr("drawn by itself"));
  EXPECT_THAT(receiving.steps, ElementsAre("AIV_Server>Simulator zoneConfiguration", "Simulator>RTM initialise",
                                           "Simulator>RTM circuitFactory", "RTM>Simulator circuitFactory",
                                           "Simulator>CircuitFactory circuit", "CircuitFactory>Simulator circuit",
                                           "Simulator>Circuit draw", "Circuit>Simulator draw"));
}

TEST(CircuitRequest, is_not_made_for_the_zone_that_is_in_force_already) {
  Receiving receiving;
  ASSERT_TRUE(receiving.receive("yard"));
  receiving.steps.clear();
  EXPECT_EQ(receiving.receive("yard"), Simulator::Reception::same);
  EXPECT_TRUE(receiving.steps.empty());
  ASSERT_TRUE(receiving.receive("dock"));
  EXPECT_EQ(receiving.factory.made->drawn, 1);
}

TEST(CircuitRequest, ends_where_the_rtm_refuses_and_no_later_step_is_shown) {
  Receiving receiving;
  ASSERT_TRUE(receiving.receive("yard"));
  const auto before = receiving.factory.made;
  receiving.steps.clear();
  EXPECT_FALSE(receiving.receive("none"));
  EXPECT_THAT(receiving.steps, ElementsAre("AIV_Server>Simulator zoneConfiguration", "Simulator>RTM initialise",
                                           "RTM>Simulator refused"));
  EXPECT_EQ(receiving.simulator.zone(), before->zone()) << "the zone before stays in force";
  EXPECT_EQ(before->drawn, 1);
}

}  // namespace
}  // namespace cosiva::virtual_side
