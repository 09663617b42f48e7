#!/usr/bin/env python3
"""No member is forgotten in a snapshot.

A class that lists its state for snapshots (`void archive(Archive& archive);`, src/base/archive.h) names each of its data
members in the body of that function, or the member is an exception below, with its kind:

constant  follows from how the object is constructed, and never changes afterwards
derived   is made again from other members when they are read
scratch   is set before each use, within the handling of one input
renewed   begins again when the emulated world starts again: random draws, connections, measurements

References need no exception. --self-test checks the check.
"""

import re
import sys

import checker

EXCEPTIONS = {
    "Agent": {"speed_policy_": "constant", "envelope_": "constant", "one_way_": "constant", "barrier_m_": "scratch"},
    "Antenna": {"by_section_": "derived"},
    "AivProxy": {"identity": "derived"},
    "ActionExecutor": {"parts_": "constant"},
    "BoardLink": {
        "board_": "constant", "connected_": "renewed", "fresh_": "renewed", "hello_due_": "renewed",
        "heartbeat_": "renewed", "encoder_": "renewed", "decoder_": "renewed", "received_": "scratch",
        "self_test_due_": "renewed",
    },
    "BaseWatch": {"model_": "constant", "gap_": "scratch", "crossing_finder_": "constant", "on_base_": "scratch"},
    "BijectionMonitor": {"contract_": "constant"},
    "BoardsLink": {"batch_": "scratch", "boards_": "constant"},
    "ControlAreas": {"own_": "constant"},
    "Convoys": {"chain_": "scratch"},
    "CoursePosition": {"pose_": "derived"},
    "Deadlocks": {"rules_": "constant"},
    "Dems": {"line_sd_m_": "constant", "random_": "renewed"},
    "DistanceCounter": {"step_m_max_": "constant"},
    "DrivingContext": {"crossings_": "constant", "negotiation_": "renewed"},
    "OrderProgress": {"move_left_m_": "renewed"},
    "Estimating": {"registry_": "constant", "model_": "constant"},
    "FleetPlan": {"options_": "constant", "distances_": "derived", "search_": "scratch", "next_": "scratch"},
    "JointStep": {
        "fleet_": "scratch", "permissions_": "scratch", "changes_": "scratch", "decisions_": "scratch",
        "failed_": "scratch", "pool_": "scratch", "budget_": "scratch", "left_": "scratch", "floor_": "constant",
    },
    "LineVehicle": {
        "circuit_": "derived",
        "goes_on_": "scratch", "step_distance_m_": "scratch", "step_manoeuvre_": "scratch", "may_end_here_": "derived",
    },
    "MessagePublisher": {"as_values_": "constant", "effects_": "scratch", "opened_at_": "scratch"},
    "Missions": {"map_": "derived", "router_": "derived"},
    "Neighbours": {
        "self_": "constant", "model_": "constant", "speed_mps_max_": "constant", "gap_": "scratch",
        "crossing_finder_": "constant", "approached_": "scratch", "newest_at_": "derived",
    },
    "ObstacleWatch": {"one_way_": "constant", "corridor_": "scratch", "sweep_": "scratch"},
    "OffPathEstimator": {"landed_m_": "constant", "landed_rad_": "constant"},
    "OnPathEstimator": {"model_": "constant"},
    "PassingOrder": {"floor_": "constant"},
    "PathSearch": {
        "floor_": "constant", "horizon_": "constant", "search_": "scratch", "limit_": "scratch", "least_": "scratch",
        "stamps_": "scratch", "nodes_": "scratch", "by_cost_": "scratch",
    },
    "LoadBay": {"positions_": "constant"},
    "OrderActions": {"catalogue_": "constant"},
    "OrderBook": {"catalogue_": "constant", "locator_": "constant"},
    "OrderManager": {"follower_": "scratch"},
    "OrderSession": {"context_": "constant", "vehicle_": "constant"},
    "PerceivedWorld": {"model_": "constant", "gap_": "scratch"},
    "PlannedGoals": {"stations_": "derived", "waypoints_": "derived"},
    "PlannedRoutes": {"base_": "scratch"},
    "PositionEstimator": {"reading_latency_s_": "constant"},
    "PositionStore": {"start_": "constant", "as_values_": "constant"},
    "RecentP99": {"last_over_": "renewed"},
    "Registry": {
        "interface_name_": "constant", "vehicles_max_": "constant", "topics_": "derived", "names_": "derived",
        "numbers_": "derived", "vacant_": "derived",
    },
    "Obstacles": {"shape_": "constant", "world_": "derived", "discs_": "derived"},
    "Odometer": {
        "noise_m_per_sqrt_m_": "constant", "slip_per_mps2_": "constant", "random_": "renewed", "scale_": "constant",
    },
    "Pmot": {
        "train_": "constant", "acceleration_mps2_": "scratch", "lag_dt_s_": "derived", "motor_blend_": "derived",
        "turn_blend_": "derived",
    },
    "PowerTrain": {"cart_": "constant"},
    "ServerProxy": {"id_": "constant", "as_values_": "constant", "topics_": "constant"},
    "AgentProxy": {"agent_": "constant"},
    "FleetProxies": {"as_values_": "constant", "intent_topic_": "derived"},
    "Reservations": {
        "floor_": "constant", "horizon_": "constant", "cycles_": "constant", "owners_": "derived",
        "sweepers_": "derived", "visited_": "scratch", "open_": "scratch", "chain_": "scratch",
    },
    "StateReporter": {
        "serial_number_": "constant", "actions_": "constant", "state_period_": "constant",
        "visualization_period_": "constant",
    },
    "Supervision": {"timeout_": "constant", "rali_fitted_": "constant"},
    "TagReader": {"map_": "derived", "noise_": "constant", "random_": "renewed", "free_": "derived"},
    "ThirdPartyPause": {"map_": "derived"},
    "TrackFleet": {"track_": "constant", "options_": "constant", "seed_": "constant", "distances_": "derived", "open_": "derived"},
    "Traces": {"capacity_": "constant", "raw_budget_": "constant"},
    "Traffic": {"rules_": "constant", "map_": "derived", "scratch_": "scratch", "between_": "scratch"},
    "V2xParticipant": {"mode_": "constant", "id_": "constant", "name_": "constant", "enabled_": "constant"},
    "Vehicle": {
        "number_": "constant", "step_max_": "constant", "floor_": "derived", "draw_": "renewed", "seed_": "constant",
        "readings_": "scratch",
    },
    "VehicleBoards": {
        "number_": "constant", "range_sd_m_": "constant", "range_dropout_": "constant", "range_random_": "renewed",
        "ports_": "constant", "out_": "scratch", "batch_": "renewed", "rali_fitted_": "constant", "powered_": "derived",
    },
    "VehicleState": {"one_way_": "constant"},
    "VirtualBody": {"zone_": "derived", "next_": "derived"},
    "VirtualFleet": {"v2x_": "constant", "open_": "constant", "effects_": "scratch"},
    "VirtualObstaclePublisher": {"world_": "scratch", "near_": "scratch", "sent_objects_": "scratch"},
    "VirtualPerception": {"contact_": "scratch"},
    "WindowPlanner": {
        "floor_": "constant", "distances_": "constant", "options_": "constant", "itineraries_": "derived",
        "delayed_": "scratch", "group_": "scratch", "old_paths_": "scratch", "found_": "scratch",
    },
    "WaitGraph": {"components_": "scratch"},
    "ZoneChange": {"map_": "derived"},
}

# The server's parts are stored by ServerCore; those without a state of their own are left out.
OWNER = "src/virtual/server/core/server_core.cpp"
PARTS = {
    "augmented_parts.h": {"objects"},
    "instrument_parts.h": {"presence", "units"},
    "master_control.h": {"mission_requests"},
    "server_context.h": {"options", "topic_prefix", "topics"},
}

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
CLASS = re.compile(r"\b(?:class|struct)\s+(?:\[\[\w+\]\]\s*)?([A-Za-z_]\w*)\s*(?:final\s*)?(?::[^;{]*)?\{")
DECLARES = re.compile(r"\bvoid archive\(Archive& archive\)")


def closing(text, start):
    """The index behind the bracket that closes the one at `start`."""
    depth = 0
    for index in range(start, len(text)):
        depth += (text[index] in "{(") - (text[index] in "})")
        if depth == 0:
            return index + 1
    raise ValueError("a bracket is not closed")


def statements(body):
    """The statements of a class body at its own level; what is in brackets is left out."""
    statement, index = "", 0
    while index < len(body):
        char = body[index]
        if char in "{(":
            end = closing(body, index)
            statement += "{}" if char == "{" else "()"
            # A function's body ends its statement; after an initialiser something of the same statement follows.
            if char == "{" and not re.match(r"\s*[;,{=]", body[end:]):
                statement = ""
            index = end
            continue
        if char == ";":
            yield " ".join(statement.split())
            statement = ""
        else:
            statement += char
        index += 1


def members_of(body):
    """Names of the data members, without static ones and references."""
    body = re.sub(r"\b(public|private|protected):", "", body)
    for statement in statements(body):
        if re.match(r"(using|friend|static|enum|class|struct|template|typedef|explicit|virtual)\b", statement):
            continue
        plain = re.sub(r"\[\[\w+\]\]", "", statement)
        while re.search(r"<[^<>]*>", plain):
            plain = re.sub(r"<[^<>]*>", "", plain)
        if "(" in plain or not plain.strip() or "operator" in plain:
            continue
        plain = re.sub(r"(\{\}|=.*|\[[^\]]*\])*\s*$", "", plain).strip()
        names = re.match(r"(?P<type>.*[\s&*>])(?P<name>[A-Za-z_]\w*)$", plain)
        if names and "&" not in names["type"]:
            yield names["name"]


def body_of(text, name):
    """The body of the function archive() of a class; None: it is not defined in this text."""
    found = re.search(rf"\bvoid (?:\w+::)*{name}::archive\(Archive& archive\)\s*\{{", text)
    return None if not found else text[found.end() - 1 : closing(text, found.end() - 1)]


def classes_of(header):
    """(name, body) of the classes that declare archive(), without their nested classes' bodies."""
    header = COMMENT.sub("", header)
    for found in CLASS.finditer(header):
        body = header[found.end() : closing(header, found.end() - 1) - 1]
        own = body
        for nested in reversed(list(CLASS.finditer(body))):
            end = closing(body, nested.end() - 1)
            own = own[: nested.start()] + own[end:] if end <= len(own) else own
        if DECLARES.search(own):
            yield found[1], own


def problems_of(header, source, exceptions):
    """What is missing in one header with its source."""
    source = COMMENT.sub("", source)
    for name, body in classes_of(header):
        stored = body_of(source, name)
        if stored is None:
            yield f"{name}: archive() is not defined in the source of the same name"
            continue
        known = exceptions.get(name, {})
        members = list(members_of(body))
        for member in members:
            if not re.search(rf"\b{member}\b", stored) and member not in known:
                yield f"{name}: {member} is neither stored nor an exception"
            if re.search(rf"archive\([^;]*\b{member}\b", stored) and member in known:
                yield f"{name}: {member} is stored and an exception"
        for member in known:
            if member not in members:
                yield f"{name}: the exception {member} is no member"


def check_parts(root):
    """The parts of the server that its owner does not store."""
    owner = root / OWNER
    stored = body_of(COMMENT.sub("", owner.read_text()), "Impl") if owner.exists() else ""
    for header, stateless in PARTS.items():
        path = root / "src/virtual/server/context" / header
        if not path.exists():
            continue
        text = COMMENT.sub("", path.read_text())
        found = next(CLASS.finditer(text))
        for member in members_of(text[found.end() : closing(text, found.end() - 1) - 1]):
            if not re.search(rf"\.{member}\b", stored) and member not in stateless:
                yield f"{path.relative_to(root)}: {member} is not stored by {OWNER}"


def check(root):
    classes, problems = 0, []
    for header in sorted((root / "src").rglob("*.h")):
        text, source = header.read_text(), header.with_suffix(".cpp")
        if not DECLARES.search(text) or not source.exists():
            continue
        classes += len(list(classes_of(text)))
        problems += [f"{header.relative_to(root)}: {p}" for p in problems_of(text, source.read_text(), EXCEPTIONS)]
    return classes, problems + list(check_parts(root))


# ---- self-test -------------------------------------------------------------------------------------------------------

# `Traces` has exceptions above.
CLASS_OF_STATE = """
class Traces {
 public:
  explicit Traces(int x) : x_{x}, inner_{} { run(); }
  void archive(Archive& archive);
  [[nodiscard]] std::map<int, std::vector<int>> all() const { return {}; }
  static constexpr int limit{3};
 private:
  struct Inner { int a{}; };
  enum class Kind { some, none };
  int x_{0};  ///< of { it
  std::vector<Inner> inner_;
  std::array<std::optional<int>, 3> three_{};
  Other& other_;
  double left_[3];
  std::size_t capacity_;
  std::size_t raw_budget_ = 7;
};
"""
LIST = "void Traces::archive(Archive& archive) { archive(x_, inner_, three_, left_); }"
GOOD = {
    "src/a/traces.h": CLASS_OF_STATE,
    "src/a/traces.cpp": LIST,
    "src/virtual/server/context/master_control.h": "struct MasterControl {\n Context& served;\n Traces traces{served};\n"
    "  MissionRequests mission_requests{};\n};",
    OWNER: "void ServerCore::Impl::archive(Archive& archive) { archive(master.traces); }",
}
BAD = [
    ({"src/a/traces.cpp": LIST.replace("inner_, ", "")}, "Traces: inner_ is neither stored nor an exception"),
    ({"src/a/traces.cpp": LIST.replace(", left_", "")}, "Traces: left_ is neither stored nor an exception"),
    ({"src/a/traces.cpp": LIST.replace("left_", "left_, capacity_")}, "capacity_ is stored and an exception"),
    ({"src/a/traces.cpp": ""}, "archive() is not defined"),
    ({"src/a/traces.cpp": "// " + LIST}, "archive() is not defined"),
    ({"src/a/traces.h": CLASS_OF_STATE.replace("raw_budget_", "budget_")}, "the exception raw_budget_ is no member"),
    ({OWNER: "void ServerCore::Impl::archive(Archive& archive) { archive(now); }"}, "traces is not stored by"),
]


if __name__ == "__main__":
    sys.exit(checker.main("snapshot", __doc__, "classes", check, GOOD, BAD))
