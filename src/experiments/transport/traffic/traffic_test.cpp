#include "cosiva/experiments/transport/traffic/traffic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "cosiva/experiments/transport/traffic/heat_map.h"
#include "cosiva/experiments/transport/traffic/test_zone.h"
#include "cosiva/experiments/transport/traffic/traffic_report.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments {
namespace {

using ::testing::HasSubstr;

TrafficOptions options(std::shared_ptr<const zone::TrafficZone> zone, std::size_t aivs, double duration_s) {
  TrafficOptions options;
  options.zone = std::move(zone);
  options.aivs = aivs;
  options.duration_s = duration_s;
  return options;
}
TrafficRun run_of(TrafficOptions options) {
  auto run = TrafficRun::make(std::move(options));
  EXPECT_TRUE(run) << to_string(run.error());
  while (run->advance(60.0)) {
  }
  return std::move(*run);
}

TEST(Distribution, gives_percentiles_that_are_values) {
  const Distribution d = distribution_of({4.0, 1.0, 3.0, 2.0});
  EXPECT_EQ(d.count, 4U);
  EXPECT_EQ(d.mean, 2.5);
  EXPECT_EQ(d.p50, 2.0);
  EXPECT_EQ(d.p90, 4.0);
  EXPECT_EQ(d.max, 4.0);
  EXPECT_EQ(distribution_of({}).count, 0U);
  std::vector<double> hundred(100);
  for (std::size_t i = 0; i < 100; ++i) hundred[i] = static_cast<double>(100 - i);
  EXPECT_EQ(distribution_of(hundred).p90, 90.0);
  EXPECT_EQ(distribution_of(hundred).p99, 99.0);
}

TEST(Traffic, of_one_circulating_vehicle_consists_of_laps_of_the_circuit_s_length_at_its_speed) {
  const TrafficRun run = run_of(options(cycle(), 1, 3600.0));
  const TrafficMetrics f = run.metrics();
  // 12 m and two half circles of 1 m: 18.28 m at the medium profile's 0.4 m/s, or the fast one's 0.5 m/s.
  const double lap_m = 12.0 + 2.0 * 3.14159265358979;
  ASSERT_GT(f.lap_s.size(), 50U);
  const double lap_s = distribution_of(f.lap_s).p50;
  EXPECT_NEAR(lap_s, lap_m / f.mean_speed_mps, 1.01) << "samples come once a second";
  EXPECT_NEAR(f.laps_per_hour, 3600.0 / lap_s, 2.0);
  EXPECT_NEAR(f.distance_m, 3600.0 * f.mean_speed_mps, 1e-6);
  EXPECT_LT(f.waiting_ratio, 0.01);
  EXPECT_EQ(f.jobs_due, 0U);
  EXPECT_TRUE(f.good());
}

TEST(Traffic, carries_jobs_one_after_the_other) {
  TrafficOptions wanted = options(yard(), 1, 600.0);
  wanted.warm_up_s = 0.0;
  wanted.jobs = {{10.0, 0, 2, 0}, {11.0, 1, 2, 0}, {12.0, 2, 0, 9}};
  const TrafficRun run = run_of(wanted);
  const auto& courses = run.dispatcher().courses();
  for (const JobCourse& course : courses) {
    ASSERT_TRUE(course.done_s);
    EXPECT_GE(*course.done_s - *course.fetched_s, 2.0 * wanted.handling_s);
    EXPECT_EQ(course.vehicle, 0U);
  }
  EXPECT_EQ(*courses[0].done_s, *courses[2].given_s) << "the vehicle was already driving; then the higher priority";
  EXPECT_EQ(*courses[2].done_s, *courses[1].given_s);
  const TrafficMetrics f = run.metrics();
  EXPECT_EQ(f.jobs_done, 3U);
  EXPECT_EQ(f.jobs_open, 0U);
  EXPECT_GT(f.busy_ratio, 0.2);
}

TEST(Traffic, assigns_a_job_to_the_vehicle_that_arrives_first) {
  TrafficOptions wanted = options(yard(), 4, 300.0);
  wanted.warm_up_s = 0.0;
  wanted.jobs = {{30.0, 1, 2, 0}};
  auto run = TrafficRun::make(wanted);
  ASSERT_TRUE(run);
  while (run->time_s() < 29.95) ASSERT_TRUE(run->advance(0.1));
  // In one direction of travel: the nearest vehicle behind the station.
  const zone::Circuit& circuit = yard()->circuit;
  const zone::TrackPosition station = yard()->stations[1].position;
  double nearest_m = 1e9;
  virtual_side::Fleet::Vehicle nearest = 0;
  for (virtual_side::Fleet::Vehicle v = 0; v < 4; ++v) {
    const auto route = circuit.shortest_route(run->fleet().track_position(v), station, 100.0);
    ASSERT_TRUE(route);
    if (route->length_m > 1.0 && route->length_m < nearest_m) {
      nearest_m = route->length_m;
      nearest = v;
    }
  }
  while (run->advance(10.0)) {
  }
  EXPECT_EQ(run->dispatcher().courses()[0].vehicle, nearest);
}

TEST(Traffic, on_a_real_zone_is_busy_safe_and_reproducible) {
  const auto configuration = zone::testing::configuration_file("indus8.toml");
  const auto rtm = zone::Rtm::initialise(configuration);
  ASSERT_TRUE(rtm);
  const auto once = [&] {
    TrafficOptions wanted = options(rtm->shared_zone(), 6, 1800.0);
    wanted.jobs = *poisson_jobs(*wanted.zone, 60.0, 1920.0, 3);
    return run_of(wanted).metrics();
  };
  const TrafficMetrics f = once();
  EXPECT_GT(f.jobs_done, 15U);
  EXPECT_EQ(f.collisions, 0U);
  EXPECT_EQ(f.stuck, 0U);
  EXPECT_GE(f.smallest_gap_m, 0.0);
  for (const double wait_s : f.wait_s) EXPECT_GE(wait_s, 0.0);
  EXPECT_EQ(once().digest, f.digest);
}

TEST(Traffic, counts_every_vehicle_second_in_some_cell) {
  const TrafficRun run = run_of(options(cycle(), 3, 100.0));
  const TrafficMetrics f = run.metrics();
  double seconds = 0.0;
  for (const auto& cells : f.cells)
    for (const double s : cells.occupied_s) seconds += s;
  EXPECT_NEAR(seconds, 3.0 * 100.0, 3.01);
}

TEST(Traffic, is_refused_without_room_or_with_invalid_options) {
  EXPECT_EQ(TrafficRun::make(options(cycle(), 5000, 10.0)).error().code, "traffic.room");
  EXPECT_EQ(TrafficRun::make(options(cycle(), 1, -1.0)).error().code, "traffic.options");
  EXPECT_EQ(TrafficRun::make(options(cycle(), 1, std::nan(""))).error().code, "traffic.options");
}

TEST(TrafficReport, contains_all_metrics_and_is_self_contained) {
  TrafficOptions wanted = options(yard(), 2, 600.0);
  wanted.jobs = *poisson_jobs(*yard(), 60.0, 660.0, 1);
  const TrafficRun run = run_of(wanted);
  const TrafficMetrics f = run.metrics();
  const std::string html = to_html(*yard(), f, "cosiva traffic --zone yard");
  for (const char* part : {"jobs an hour", "Waiting", "heat map of yard", ">dock</text>", "cosiva traffic --zone yard"})
    EXPECT_THAT(html, HasSubstr(part));
  EXPECT_THAT(html, HasSubstr(f.digest));
  EXPECT_EQ(html.find("nan"), std::string::npos);
  const std::string csv = jobs_csv(*yard(), run.dispatcher(), run.time_s());
  EXPECT_THAT(csv, HasSubstr("due_s,from,to,priority,vehicle,given_s,fetched_s,done_s\n"));
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(csv, '\n')), run.dispatcher().jobs().size() + 1);
}

}  // namespace
}  // namespace cosiva::experiments
