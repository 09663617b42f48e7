#include "cosiva/virtual/server/core/server_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;

TEST(ServerView, shows_a_broken_connection_at_once_and_keeps_the_twin) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  fixture.kill(aiv);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("connection"), "CONNECTIONBROKEN");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), true);
  fixture.run_for(10s);
  EXPECT_EQ(*fixture.bijection().number("matched"), 1.0);
  EXPECT_GT(*fixture.aiv("CoSiVA/AIV1").number("age_ms"), 9000.0);
}

TEST(ServerView, shows_an_unresponsive_vehicle_as_lost_after_a_second_and_stops_its_twin) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  const double x0 = *fixture.aiv("CoSiVA/AIV1").number("x");
  aiv.alive = false;
  fixture.run_for(900ms);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), false);
  fixture.run_for(300ms);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("lost"), true);
  const JsonValue then = fixture.aiv("CoSiVA/AIV1");
  fixture.run_for(5s);
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV1").number("x"), *then.number("x"));
  EXPECT_LE(std::fabs(*then.number("x") - x0), 0.3 * 1.0 + 0.05) << "extrapolated for a second at most";
  EXPECT_EQ(then.find("contract")->flag("age"), false);
}

/// A third-party vehicle that publishes only its state, and the ratio of the time for which it is shown as lost.
class SlowReporter {
 public:
  SlowReporter() : vehicle_{fixture_.add("agv-7", {0, 0.5}, "Acme")} {
    vehicle_.alive = false;  // the fixture does not report for it
    fixture_.each_step = [this] {
      if (const auto lost = fixture_.aiv("Acme/agv-7").flag("lost")) ++(*lost ? steps_lost_ : steps_live_);
    };
  }
  void report_for(SimDuration duration, double period_s, double jitter_s = 0.0) {
    for (const SimTime end = fixture_.now + duration; fixture_.now < end;) {
      fixture_.send(vehicle_, "state", vda::encode(vehicle_.state(fixture_.now)));
      be_unresponsive_for(from_seconds(period_s + fixture_.random.uniform(-jitter_s, jitter_s)));
    }
  }
  void be_unresponsive_for(SimDuration duration) { fixture_.run_for(duration); }
  [[nodiscard]] double lost_ratio() const {
    return static_cast<double>(steps_lost_) / static_cast<double>(steps_lost_ + steps_live_);
  }
  [[nodiscard]] bool lost() const { return *fixture_.aiv("Acme/agv-7").flag("lost"); }

 private:
  ServerFixture fixture_;
  FixtureVehicle& vehicle_;
  std::uint64_t steps_lost_{0};
  std::uint64_t steps_live_{0};
};

TEST(ServerView, never_shows_a_vehicle_with_a_constant_slow_rate_as_lost) {
  for (const double period_s : {1.2, 2.0, 3.0}) {
    for (const double jitter_s : {0.0, 0.3 * period_s}) {
      SlowReporter vehicle;
      vehicle.report_for(60s, period_s, jitter_s);
      EXPECT_EQ(vehicle.lost_ratio(), 0.0) << "a state every " << period_s << " s, give or take " << jitter_s;
    }
  }
}

TEST(ServerView, shows_a_slow_vehicle_as_lost_after_three_of_its_usual_gaps) {
  for (const double period_s : {1.2, 2.0, 3.0}) {
    SlowReporter vehicle;
    vehicle.report_for(180s, period_s);  // and one gap without a report already
    vehicle.be_unresponsive_for(from_seconds(1.9 * period_s));
    EXPECT_FALSE(vehicle.lost()) << period_s;
    vehicle.be_unresponsive_for(from_seconds(0.2 * period_s));
    EXPECT_TRUE(vehicle.lost()) << period_s;
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
