#include "cosiva/experiments/battery/procedure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Kind = ProcedureCommand::Kind;

constexpr SimTime t0 = virtual_epoch;

/// Vehicles whose charge falls as specified, sampled ten times per second.
struct Fixture {
  Procedure procedure;
  SimTime now{t0};
  std::vector<ProcedureCommand> received;

  explicit Fixture(ProcedureOptions options) : procedure{options} { receive(procedure.start(now)); }

  void receive(const ProcedureCommands& commands) { received.insert(received.end(), commands.begin(), commands.end()); }
  void ready(std::size_t vehicle, const std::string& id, double charge = 1.0, double celsius = 22.0) {
    receive(procedure.on_ready(now, vehicle, {id, "lipo850", 3.0, 3600.0, celsius, charge}));
  }
  void sample(std::size_t vehicle, double charge, double distance_m = 0.0) {
    receive(procedure.on_sample(vehicle, {now, charge, 0.01, 7.4, 2.0, 25.0, distance_m}));
  }
  [[nodiscard]] std::size_t count(Kind kind) const {
    std::size_t n = 0;
    for (const ProcedureCommand& command : received) n += command.kind == kind ? 1U : 0U;
    return n;
  }
  [[nodiscard]] std::string last_message() const {
    std::string phrase;
    for (const ProcedureCommand& command : received)
      if (command.kind == Kind::notify_operator) phrase = command.text;
    return phrase;
  }
};

TEST(Sampled, follows_the_article_s_exchange_from_change_to_floor) {
  Fixture fixture{{.vehicles = 1, .floor = 0.2}};
  EXPECT_EQ(fixture.count(Kind::change_battery), 1U);
  EXPECT_EQ(fixture.last_message(), "run 1: put battery 1, full, into AIV1");
  fixture.ready(0, "B7");
  EXPECT_EQ(fixture.count(Kind::run), 1U);
  // One percent a second: 20 % is crossed after 80 s exactly, between two samples.
  for (int i = 1; !fixture.procedure.done() && i < 2000; ++i) {
    fixture.now = t0 + i * 300ms;
    fixture.sample(0, 1.0 - 0.003 * i, 0.15 * i);
  }
  ASSERT_TRUE(fixture.procedure.done());
  EXPECT_EQ(fixture.count(Kind::stop), 1U);
  const BatteryRun& run = fixture.procedure.records().front();
  EXPECT_EQ(run.stop, StopCause::floor);
  EXPECT_NEAR(run.autonomy_s, 80.0, 1e-6);
  EXPECT_NEAR(run.charge_ah, 2.0 * 79.7 / 3600.0, 1e-6);  // counted from the first sample
  EXPECT_NEAR(run.energy_wh, 2.0 * 7.4 * 79.7 / 3600.0, 1e-6);
  EXPECT_NEAR(run.distance_m, 0.5 * 79.7, 1e-6);
  EXPECT_NEAR(run.charge_end, 0.2, 1e-9);
  EXPECT_EQ(run.tag.id, "B7");
  EXPECT_EQ(run.tag.cycles, 3.0);
  // The record ends with the crossing, three seconds before the end was certain.
  EXPECT_EQ(to_seconds(run.curve.back().at - t0), run.autonomy_s);
}

TEST(Sampled, has_a_curve_that_rises_in_time_up_to_the_crossing) {
  Fixture fixture{{.vehicles = 1, .floor = 0.2, .curve_every = 300ms}};
  fixture.ready(0, "B7");
  for (int i = 1; !fixture.procedure.done() && i < 2000; ++i) {
    fixture.now = t0 + i * 300ms;
    fixture.sample(0, 1.0 - 0.003 * i, 0.15 * i);
  }
  const std::vector<BatterySample>& curve = fixture.procedure.records().front().curve;
  ASSERT_GT(curve.size(), 260U);
  for (std::size_t i = 1; i < curve.size(); ++i) ASSERT_LT(curve[i - 1].at, curve[i].at) << i;
  EXPECT_EQ(curve.back().at, t0 + 80s);
}

TEST(Sampled, does_not_end_at_a_sag) {
  Fixture fixture{{.vehicles = 1, .floor = 0.2}};
  fixture.ready(0, "B7");
  const auto run = [&](int from_s, int to_s, double charge) {
    for (int i = 10 * from_s + 1; i <= 10 * to_s; ++i) {
      fixture.now = t0 + i * 100ms;
      fixture.sample(0, charge);
    }
  };
  run(0, 10, 0.25);
  run(10, 12, 0.19);  // two seconds below
  run(12, 20, 0.21);
  EXPECT_FALSE(fixture.procedure.done());
  run(20, 24, 0.19);
  ASSERT_TRUE(fixture.procedure.done());
  EXPECT_NEAR(fixture.procedure.records().front().autonomy_s, 20.05, 0.051);
}

TEST(Sampled, refuses_a_battery_that_is_not_full_or_too_cold_or_hot) {
  Fixture fixture{{.vehicles = 1, .temperature_min_c = 15.0, .temperature_max_c = 30.0}};
  fixture.ready(0, "B7", 0.8);
  EXPECT_THAT(fixture.last_message(), HasSubstr("AIV1 may not run: it is not full: 80 %"));
  fixture.ready(0, "B7", 1.0, 8.0);
  EXPECT_THAT(fixture.last_message(), HasSubstr("out of the band: 8 °C"));
  fixture.ready(0, "B7", 1.0, 45.0);
  EXPECT_EQ(fixture.count(Kind::run), 0U);
  EXPECT_EQ(fixture.count(Kind::change_battery), 4U);  // requested again each time
  fixture.ready(0, "B7");
  EXPECT_EQ(fixture.count(Kind::run), 1U);
  fixture.ready(0, "B8");  // ignored during the run
  EXPECT_EQ(fixture.count(Kind::run), 1U);
}

TEST(Sampled, names_why_the_run_stopped) {
  for (const StopCause cause : {StopCause::cut_off, StopCause::fault, StopCause::operator_stop}) {
    Fixture fixture{{.vehicles = 1}};
    fixture.ready(0, "B7");
    fixture.now = t0 + 10s;
    fixture.sample(0, 0.9);
    fixture.receive(fixture.procedure.on_stop(t0 + 12s, 0, cause));
    ASSERT_TRUE(fixture.procedure.done());
    const BatteryRun& run = fixture.procedure.records().front();
    EXPECT_EQ(run.stop, cause);
    EXPECT_EQ(run.autonomy_s, 12.0);
    EXPECT_EQ(run.ended(), cause == StopCause::cut_off);
    EXPECT_EQ(parse_stop(to_string(cause)), cause);
  }
  EXPECT_EQ(parse_stop("tired"), std::nullopt);
}

TEST(Sampled, counts_a_lost_vehicle_until_its_last_report) {
  Fixture fixture{{.vehicles = 1}};
  fixture.ready(0, "B7");
  fixture.now = t0 + 100s;
  fixture.sample(0, 0.9);
  fixture.receive(fixture.procedure.tick(t0 + 129s));
  EXPECT_FALSE(fixture.procedure.done());
  fixture.receive(fixture.procedure.tick(t0 + 131s));
  ASSERT_TRUE(fixture.procedure.done());
  EXPECT_EQ(fixture.procedure.records().front().stop, StopCause::lost);
  EXPECT_EQ(fixture.procedure.records().front().autonomy_s, 100.0);
}

TEST(Sampled, names_the_battery_as_cause_where_the_charge_was_below_the_floor) {
  Fixture fixture{{.vehicles = 1}};
  fixture.ready(0, "B7");
  fixture.now = t0 + 100s;
  fixture.sample(0, 0.21);
  fixture.now = t0 + 101s;
  fixture.sample(0, 0.19);
  fixture.receive(fixture.procedure.on_stop(t0 + 102s, 0, StopCause::fault));
  EXPECT_EQ(fixture.procedure.records().front().stop, StopCause::floor);
  EXPECT_NEAR(fixture.procedure.records().front().autonomy_s, 100.5, 1e-6);
}

TEST(Sampled, records_pauses_separately) {
  Fixture fixture{{.vehicles = 1, .pause_every = 10s, .pause_for = 5s}};
  fixture.ready(0, "B7");
  bool paused = false;
  double charge = 1.0;
  for (int i = 1; !fixture.procedure.done() && i < 5000; ++i) {
    fixture.now = t0 + i * 100ms;
    if (!paused) charge -= 0.002;
    const std::size_t before = fixture.received.size();
    fixture.sample(0, charge);
    for (std::size_t k = before; k < fixture.received.size(); ++k) {
      if (fixture.received[k].kind == Kind::pause) paused = true;
      if (fixture.received[k].kind == Kind::resume) paused = false;
    }
  }
  ASSERT_TRUE(fixture.procedure.done());
  const BatteryRun& run = fixture.procedure.records().front();
  EXPECT_NEAR(run.autonomy_s, 40.0, 0.7);  // 0.8 at 0.02 a second, without pauses
  EXPECT_NEAR(run.paused_s, 15.0, 0.1);
}

TEST(Sampled, ignores_late_and_repeated_samples) {
  Fixture fixture{{.vehicles = 1}};
  fixture.ready(0, "B7");
  fixture.now = t0 + 10s;
  fixture.sample(0, 0.9);
  fixture.now = t0 + 5s;
  fixture.sample(0, 0.1);
  fixture.now = t0 + 10s;
  fixture.sample(0, 0.1);
  fixture.now = t0 + 20s;
  fixture.sample(0, 0.8);
  EXPECT_FALSE(fixture.procedure.done());
}

TEST(Fleet, runs_when_the_last_is_ready_and_is_done_when_the_last_has_stopped) {
  Fixture fixture{{.vehicles = 3}};
  fixture.ready(0, "A");
  fixture.ready(2, "C");
  EXPECT_EQ(fixture.count(Kind::run), 0U);
  fixture.now = t0 + 60s;
  fixture.ready(1, "B");
  EXPECT_EQ(fixture.count(Kind::run), 3U);
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_FALSE(fixture.procedure.done());
    fixture.receive(fixture.procedure.on_stop(t0 + 60s + 10s * static_cast<int>(v + 1), v, StopCause::cut_off));
  }
  EXPECT_TRUE(fixture.procedure.done());
  EXPECT_NEAR(fixture.procedure.records()[2].autonomy_s, 30.0, 1e-9);
}

TEST(Fleet, swaps_batteries_by_a_latin_square_and_refuses_a_wrong_one) {
  Fixture fixture{{.vehicles = 2, .runs = 2, .swap = true}};
  fixture.ready(0, "A");
  fixture.ready(1, "B");
  for (std::size_t v = 0; v < 2; ++v) fixture.receive(fixture.procedure.on_stop(t0 + 10s, v, StopCause::cut_off));
  EXPECT_EQ(fixture.procedure.run(), 1U);
  EXPECT_EQ(fixture.procedure.battery_of(1, 0), 1U);
  fixture.ready(0, "A");
  EXPECT_THAT(fixture.last_message(), HasSubstr("'A' is battery 1, requested was 2"));
  fixture.ready(0, "X");
  EXPECT_THAT(fixture.last_message(), HasSubstr("battery 2 was 'B', this is 'X'"));
  fixture.ready(0, "B");
  fixture.ready(1, "A");
  EXPECT_EQ(fixture.count(Kind::run), 4U);
}

TEST(Procedure, reports_its_progress_and_its_expected_end) {
  Fixture fixture{{.vehicles = 2, .floor = 0.2}};
  EXPECT_FALSE(fixture.procedure.progress(fixture.now).expected_end);
  fixture.ready(0, "A");
  fixture.ready(1, "B");
  fixture.now = t0 + 100s;
  fixture.sample(0, 0.8);
  fixture.sample(1, 0.6);
  const auto progress = fixture.procedure.progress(fixture.now);
  EXPECT_NEAR(progress.ratio, (0.25 + 0.5) / 2.0, 1e-9);
  ASSERT_TRUE(progress.expected_end);
  EXPECT_NEAR(to_seconds(*progress.expected_end - t0), 400.0, 1e-6);
}

TEST(Procedure, continues_from_its_saved_state_after_every_sample_with_the_same_result) {
  const ProcedureOptions options{
      .vehicles = 2, .runs = 2, .swap = true, .floor = 0.5, .pause_every = 20s, .pause_for = 3s};
  const auto play = [&](bool crashes) {
    Fixture fixture{options};
    for (int run = 0; run < 2; ++run) {
      fixture.ready(0, run == 0 ? "A" : "B");
      fixture.ready(1, run == 0 ? "B" : "A");
      for (int i = 1; i < 800 && fixture.procedure.run() == static_cast<std::size_t>(run); ++i) {
        fixture.now += 100ms;
        for (std::size_t v = 0; v < 2; ++v) {
          if (crashes) {
            Procedure again{options};
            EXPECT_TRUE(again.restore(fixture.procedure.state_json()));
            fixture.procedure = again;
          }
          fixture.sample(v, 1.0 - 0.001 * i - 0.0002 * i * static_cast<double>(v), 0.05 * i);
        }
      }
    }
    EXPECT_TRUE(fixture.procedure.done());
    return fixture.procedure.state_json();
  };
  EXPECT_EQ(play(true), play(false));
}

TEST(Procedure, refuses_the_state_of_another_test_or_a_broken_state) {
  Procedure one{{.vehicles = 2}};
  static_cast<void>(one.start(t0));
  const std::string state = one.state_json();
  EXPECT_TRUE(Procedure{{.vehicles = 2}}.restore(state));
  EXPECT_EQ(Procedure{{.vehicles = 3}}.restore(state).error().code, "battery.state");
  EXPECT_EQ((Procedure{{.vehicles = 2, .floor = 0.3}}.restore(state).error().code), "battery.state");
  for (const std::string& bad : {std::string{}, std::string{"{}"}, state.substr(0, state.size() / 2)})
    EXPECT_EQ(one.restore(bad).error().code, "battery.state");
  std::string wrong = state;
  wrong.replace(wrong.find("\"phase\":0"), 9, "\"phase\":9");
  EXPECT_FALSE(one.restore(wrong));
  EXPECT_EQ(one.state_json(), state);
}

TEST(Fleet, makes_no_further_run_when_its_records_suffice_but_ends_no_run_early) {
  std::size_t requested = 0;
  ProcedureOptions options{.vehicles = 2, .runs = 5};
  options.enough = [&](const std::vector<BatteryRun>& records) {
    ++requested;
    return records.size() >= 4;
  };
  Fixture fixture{options};
  const auto run_once = [&] {
    for (std::size_t v = 0; v < 2; ++v) fixture.ready(v, "B" + std::to_string(v + 1));
    const SimTime began = fixture.now;
    const std::size_t run = fixture.procedure.run();
    for (int i = 1; fixture.procedure.run() == run && i < 2000; ++i) {
      fixture.now = began + i * 300ms;
      for (std::size_t v = 0; v < 2; ++v)
        if (fixture.procedure.running(v)) fixture.sample(v, 1.0 - (0.003 + 0.001 * static_cast<double>(v)) * i);
    }
  };
  run_once();
  EXPECT_EQ(requested, 1U);  // when both had ended, not when the first had
  EXPECT_FALSE(fixture.procedure.done());
  run_once();
  ASSERT_TRUE(fixture.procedure.done());
  EXPECT_EQ(fixture.procedure.records().size(), 4U);
  EXPECT_EQ(fixture.last_message(), "the test ends after run 2 of 5: the mean is known as well as was wanted");
  EXPECT_EQ(fixture.procedure.present_run(), 1U);
  EXPECT_EQ(fixture.procedure.slot(fixture.now, 0).stop, StopCause::floor);
  // The state saved then is that of a finished test.
  Procedure again{options};
  ASSERT_TRUE(again.restore(fixture.procedure.state_json()));
  EXPECT_TRUE(again.done());
  EXPECT_EQ(again.present_run(), 1U);
}

TEST(Fleet, makes_all_its_runs_when_its_records_never_suffice) {
  ProcedureOptions options{.vehicles = 1, .runs = 2};
  options.enough = [](const std::vector<BatteryRun>&) { return false; };
  Fixture fixture{options};
  for (int run = 0; run < 2; ++run) {
    ASSERT_FALSE(fixture.procedure.done());
    fixture.ready(0, "B1");
    const SimTime began = fixture.now;
    for (int i = 1; fixture.procedure.running(0) && i < 2000; ++i) {
      fixture.now = began + i * 300ms;
      fixture.sample(0, 1.0 - 0.003 * i);
    }
  }
  EXPECT_TRUE(fixture.procedure.done());
  EXPECT_EQ(fixture.procedure.records().size(), 2U);
}

}  // namespace
}  // namespace cosiva::experiments
