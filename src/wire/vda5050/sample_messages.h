#pragma once

#include <string>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/wire/messages/messages.h"

/// Messages drawn from a random stream, each optional field sometimes present and sometimes not: the input of the
/// codec's tests. Every drawn value survives the wire unchanged (whole milliseconds, angles in (−π, π], no
/// `unsupported`).
namespace cosiva::wire::vda5050::sample {

template <typename T>
[[nodiscard]] T any_of(Random& random, std::initializer_list<T> values) {
  return values.begin()[random.below(values.size())];
}
[[nodiscard]] inline bool coin(Random& random) { return random.chance(0.5); }
[[nodiscard]] inline std::uint32_t count(Random& random) {
  return any_of<std::uint32_t>(random, {0U, 1U, 7U, 4294967295U, static_cast<std::uint32_t>(random.below(100000))});
}
[[nodiscard]] inline double metres(Random& random) {
  return any_of<double>(random, {0.0, -0.5, 1e9, -1e9, 1e-300, random.uniform(-100.0, 100.0)});
}
[[nodiscard]] inline double positive(Random& random) { return random.uniform(0.0, 20.0); }
[[nodiscard]] inline double angle(Random& random) {
  return any_of<double>(random, {0.0, pi, -3.14159, random.uniform(-3.14, 3.14)});
}
[[nodiscard]] inline std::string id(Random& random) {
  return any_of<std::string>(
      random, {"n1", "A_12-3.b:4", "Gleis 7 \xC3\xBC\xE2\x82\xAC", "quote\"back\\slash", "tab\there",
               "\xF0\x9F\x9A\x9A", std::string("nul\0inside", 10), "id" + std::to_string(random.below(1000))});
}
[[nodiscard]] inline std::string maybe_text(Random& random) { return coin(random) ? id(random) : std::string{}; }
template <typename Draw>
[[nodiscard]] auto maybe(Random& random, Draw draw) -> std::optional<decltype(draw(random))> {
  if (coin(random)) return draw(random);
  return std::nullopt;
}
template <typename Draw>
[[nodiscard]] auto several(Random& random, std::uint64_t most, Draw draw) {
  std::vector<decltype(draw(random))> items;
  for (std::uint64_t left = random.below(most + 1); left > 0; --left) items.push_back(draw(random));
  return items;
}

[[nodiscard]] inline Header header(Random& random) {
  Header h;
  h.header_id = count(random);
  h.timestamp = SimTime{std::chrono::milliseconds{static_cast<std::int64_t>(random.below(7'000'000'000'000))}};
  h.version = any_of<std::string>(random, {"2.1.0", "2.0.0", "2", "v2", "2.1"});
  h.manufacturer = id(random);
  h.serial_number = id(random);
  return h;
}

[[nodiscard]] inline Parameter parameter(Random& random) {
  Parameter p{id(random), {}};
  switch (random.below(5)) {
    case 0: p.value = coin(random); break;
    case 1: p.value = any_of<double>(random, {0.0, -1.5, 1.6890336e12, random.gaussian()}); break;
    case 2: p.value = maybe_text(random); break;
    case 3: p.value = RawJson{R"({"a":[1,2,{"b":null}],"c":"x"})"}; break;
    default: p.value = RawJson{R"([true,"left",[]])"}; break;
  }
  return p;
}
[[nodiscard]] inline Action action(Random& random) {
  return {id(random), id(random), maybe_text(random),
          any_of(random, {BlockingType::none, BlockingType::soft, BlockingType::hard}), several(random, 3, parameter)};
}
[[nodiscard]] inline NodePosition node_position(Random& random, bool with_deviation) {
  NodePosition p{metres(random), metres(random), maybe(random, angle), {}, {}, id(random)};
  if (with_deviation) {
    p.allowed_deviation_xy_m = maybe(random, positive);
    p.allowed_deviation_theta_rad = maybe(random, angle);
  }
  return p;
}

[[nodiscard]] inline Order order(Random& random) {
  Order o{header(random), id(random), count(random), maybe_text(random), {}, {}};
  o.nodes = several(random, 6, [](Random& r) {
    return OrderNode{id(r), count(r), coin(r), maybe(r, [](Random& q) { return node_position(q, true); }),
                     several(r, 2, action)};
  });
  o.edges = several(random, 6, [](Random& r) {
    return OrderEdge{
        id(r),          count(r), coin(r), id(r), id(r), maybe(r, positive), maybe(r, positive), several(r, 2, action),
        maybe(r, coin), {}};
  });
  return o;
}
[[nodiscard]] inline InstantActions instant_actions(Random& random) {
  return {header(random), several(random, 4, action)};
}

[[nodiscard]] inline AgvPosition agv_position(Random& random) {
  return {{metres(random), metres(random), angle(random)},
          id(random),
          coin(random),
          maybe(random, [](Random& r) { return r.uniform(); }),
          maybe(random, positive)};
}
[[nodiscard]] inline Velocity velocity(Random& random) { return {metres(random), metres(random), metres(random)}; }
[[nodiscard]] inline Reference reference(Random& random) { return {id(random), maybe_text(random)}; }

[[nodiscard]] inline State state(Random& random) {
  State s;
  s.header = header(random);
  s.maps = several(random, 3, [](Random& r) { return MapInfo{id(r), id(r), maybe_text(r), coin(r)}; });
  s.order_id = maybe_text(random);
  s.order_update_id = count(random);
  s.zone_set_id = maybe_text(random);
  s.last_node_id = maybe_text(random);
  s.last_node_sequence_id = count(random);
  s.driving = coin(random);
  s.paused = coin(random);
  s.new_base_request = coin(random);
  s.distance_since_last_node_m = maybe(random, positive);
  s.operating_mode = any_of(random, {OperatingMode::automatic, OperatingMode::semiautomatic, OperatingMode::manual,
                                     OperatingMode::service, OperatingMode::teachin});
  s.node_states = several(random, 5, [](Random& r) {
    return NodeState{id(r), count(r), coin(r), maybe(r, [](Random& q) { return node_position(q, false); })};
  });
  s.edge_states = several(random, 5, [](Random& r) { return EdgeState{id(r), count(r), coin(r)}; });
  s.position = maybe(random, agv_position);
  s.velocity = maybe(random, velocity);
  s.action_states = several(random, 4, [](Random& r) {
    return ActionState{id(r), maybe_text(r),
                       any_of(r, {ActionStatus::waiting, ActionStatus::initializing, ActionStatus::running,
                                  ActionStatus::paused, ActionStatus::finished, ActionStatus::failed}),
                       maybe_text(r)};
  });
  s.loads = maybe(random, [](Random& r) {
    return several(r, 3, [](Random& q) {
      return Load{maybe_text(q), maybe_text(q), maybe_text(q), maybe(q, positive)};
    });
  });
  s.battery = {random.uniform(0.0, 100.0), maybe(random, positive), maybe(random, positive), coin(random)};
  s.errors = several(random, 3, [](Random& r) {
    return VehicleError{id(r), any_of(r, {ErrorLevel::warning, ErrorLevel::fatal}), maybe_text(r),
                        several(r, 2, reference)};
  });
  s.information = several(random, 3, [](Random& r) {
    return Information{id(r), maybe_text(r), several(r, 2, reference)};
  });
  s.e_stop = any_of(random, {EStop::none, EStop::autoack, EStop::manual, EStop::remote});
  s.field_violation = coin(random);
  return s;
}

[[nodiscard]] inline Visualization visualization(Random& random) {
  return {header(random), maybe(random, agv_position), maybe(random, velocity)};
}
[[nodiscard]] inline Connection connection(Random& random) {
  return {header(random),
          any_of(random, {ConnectionState::online, ConnectionState::offline, ConnectionState::connection_broken})};
}

[[nodiscard]] inline Factsheet factsheet(Random& random) {
  Factsheet f;
  f.header = header(random);
  f.series_name = id(random);
  f.series_description = maybe_text(random);
  f.agv_kinematic = any_of<std::string>(random, {"DIFF", "OMNI", "THREEWHEEL"});
  f.agv_class = any_of<std::string>(random, {"FORKLIFT", "CONVEYOR", "TUGGER", "CARRIER"});
  for (double* value : {&f.speed_min_mps, &f.speed_max_mps, &f.acceleration_max_mps2, &f.deceleration_max_mps2,
                        &f.height_m, &f.width_m, &f.length_m, &f.min_order_interval_s, &f.min_state_interval_s,
                        &f.default_state_interval_s, &f.visualization_interval_s})
    *value = positive(random);
  f.actions = several(random, 4, [](Random& r) {
    return Factsheet::SupportedAction{
        id(r),
        maybe_text(r),
        coin(r),
        coin(r),
        coin(r),
        several(r, 2,
                [](Random& q) {
                  return Parameter{id(q), any_of<std::string>(q, {"NUMBER", "STRING", "BOOL", "OBJECT"})};
                }),
        several(r, 2,
                [](Random& q) {
                  return Parameter{id(q), any_of<std::string>(q, {"INTEGER", "STRING"})};
                }),
        several(r, 3, [](Random& q) {
          return any_of(q, {BlockingType::none, BlockingType::soft, BlockingType::hard});
        })};
  });
  f.load_positions = several(random, 3, id);
  return f;
}

}  // namespace cosiva::wire::vda5050::sample
