#pragma once

// Plans and grounds for this folder's tests.

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/positioning/campaign/work.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments::testing {

inline CampaignGround lacet4() {
  static const auto zone = [] {
    const std::string path = source_dir() + "/zones/lacet4.toml";
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    auto rtm = zone::Rtm::initialise({"toml", path, text.str(), {}});
    EXPECT_TRUE(rtm) << to_string(rtm.error());
    return rtm->shared_zone();
  }();
  auto track = estimation::Track::of_loop(std::shared_ptr<const zone::Circuit>(zone, &zone->circuit));
  EXPECT_TRUE(track) << to_string(track.error());
  return {zone, std::make_shared<const estimation::Track>(std::move(*track))};
}

inline CampaignPlan plan_of(const std::string& text) {
  auto plan = read_campaign_plan(text, "plan.toml");
  EXPECT_TRUE(plan) << to_string(plan.error());
  return plan ? std::move(*plan) : CampaignPlan{};
}

inline CampaignWork work_of(const std::string& text) {
  auto work = CampaignWork::make(plan_of(text), lacet4());
  EXPECT_TRUE(work) << to_string(work.error());
  return std::move(*work);
}

/// Twelve cells of five runs, at most a second's work.
inline const std::string small_plan =
    "runs = 5\ndistance_m = 12\ntolerance_m = 0.009\n[vary]\nalgorithm = [\"arc_kalman\", \"reset_rule\"]\n"
    "pitch_m = [0.25, 0.5, 1.0]\nmissed_ratio = [0.0, 0.3]\n";

}  // namespace cosiva::experiments::testing
