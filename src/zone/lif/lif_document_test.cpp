// The diagnostics about the fields of a document, one by one.
#include "cosiva/zone/lif/lif_document.h"

#include <gmock/gmock.h>

#include "cosiva/base/json_value.h"
#include "cosiva/zone/lif/lif_fixture.h"

namespace cosiva::zone::lif {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct Read {
  Result<Document> document;
  std::vector<Diagnostic> diagnostics;

  /// "kind text" at a location; empty where there is none.
  [[nodiscard]] std::string at(std::string_view location) const {
    for (const Diagnostic& diagnostic : diagnostics) {
      if (diagnostic.location == location)
        return std::string(diagnostic.kind == Diagnostic::Kind::mended ? "mended "
                           : diagnostic.kind == Diagnostic::Kind::lost ? "lost "
                                                                       : "notice ") +
               diagnostic.text;
    }
    return {};
  }
  [[nodiscard]] std::string error() const { return document ? "none" : to_string(document.error()); }
};

Read read_json(const std::string& text, const Selection& selection = {}) {
  const auto value = JsonValue::parse(testing::json(text), 1U << 20U);
  EXPECT_TRUE(value) << text;
  LifDiagnostics diagnostics;
  auto document = read_document(*value, selection, diagnostics);
  return {std::move(document), diagnostics.take()};
}

const std::string good_meta =
    "'metaInformation':{'projectIdentification':'p','creator':'c','exportTimestamp':'t','lifVersion':'1.0.0'}";
const std::string node_a =
    "{'nodeId':'A','nodePosition':{'x':0,'y':0},'vehicleTypeNodeProperties':[{'vehicleTypeId':'T'}]}";
const std::string node_b =
    "{'nodeId':'B','nodePosition':{'x':2,'y':1},'vehicleTypeNodeProperties':[{'vehicleTypeId':'T'}]}";

std::string edge_with(const std::string& properties, const std::string& more = {}) {
  return "{'edgeId':'A-B','startNodeId':'A','endNodeId':'B'" + more +
         ",'vehicleTypeEdgeProperties':[{'vehicleTypeId':'T','rotationAllowed':false" + properties + "}]}";
}
std::string layout_of(const std::string& nodes, const std::string& edges, const std::string& stations = {},
                      const std::string& more = {}) {
  return "{'layoutId':'L','layoutVersion':'1'" + more + ",'nodes':[" + nodes + "],'edges':[" + edges +
         "],'stations':[" + stations + "]}";
}
std::string whole(const std::string& layouts) { return "{" + good_meta + ",'layouts':[" + layouts + "]}"; }
Read with_properties(const std::string& properties) {
  return read_json(whole(layout_of(node_a + "," + node_b, edge_with("," + properties))));
}
Read with_node(const std::string& node) {
  return read_json(whole(layout_of(node_a + "," + node_b + "," + node, edge_with(""))));
}
Read with_station(const std::string& station) {
  return read_json(whole(layout_of(node_a + "," + node_b, edge_with(""), station)));
}

const std::string properties_location = "layouts[0].edges[0].vehicleTypeEdgeProperties[0]";

TEST(LifDocument, without_faults_is_read_without_a_diagnostic) {
  const Read read = read_json(whole(layout_of(node_a + "," + node_b, edge_with(""))));
  ASSERT_TRUE(read.document) << read.error();
  EXPECT_THAT(read.diagnostics, IsEmpty());
  const Document& document = *read.document;
  EXPECT_EQ(document.project, "p");
  ASSERT_THAT(document.layouts, SizeIs(1));
  EXPECT_EQ(document.layouts[0].id, "L");
  EXPECT_EQ(document.layouts[0].level, std::nullopt);
  ASSERT_THAT(document.nodes, SizeIs(2));
  EXPECT_EQ(document.nodes[1].id, "B");
  EXPECT_EQ(document.nodes[1].location, "layouts[0].nodes[1]");
  EXPECT_EQ(document.nodes[1].layout, 0U);
  EXPECT_EQ(document.nodes[1].at, (Point2{2.0, 1.0}));
  EXPECT_FALSE(document.nodes[1].charges);
  ASSERT_THAT(document.edges, SizeIs(1));
  EXPECT_EQ(document.edges[0].id, "A-B");
  EXPECT_EQ(document.edges[0].location, "layouts[0].edges[0]");
  EXPECT_EQ(document.edges[0].from, 0U);
  EXPECT_EQ(document.edges[0].to, 1U);
  EXPECT_EQ(document.edges[0].leaving, Rotation::any);
  EXPECT_EQ(document.edges[0].arriving, Rotation::any);
  EXPECT_EQ(document.edges[0].section, "");
  EXPECT_FALSE(document.edges[0].speed_mps_max);
  EXPECT_FALSE(document.edges[0].trajectory);
}

TEST(LifDocument, scales_coordinates_by_the_selection_s_metres_per_unit) {
  const Read read = read_json(whole(layout_of(node_a + "," + node_b, edge_with(""))), {{}, {}, 0.5});
  EXPECT_EQ(read.document->nodes[1].at, (Point2{1.0, 0.5}));
}

TEST(LifDocument, names_each_missing_field_of_its_meta_information) {
  const Read read =
      read_json("{'metaInformation':{},'layouts':[" + layout_of(node_a + "," + node_b, edge_with("")) + "]}");
  for (const std::string key : {"projectIdentification", "creator", "exportTimestamp", "lifVersion"})
    EXPECT_EQ(read.at("metaInformation." + key), "mended '" + key + "' is missing; read all the same");
  EXPECT_EQ(read.document->project, "");
}

TEST(LifDocument, accepts_any_version_1_and_names_another) {
  const auto version = [](const std::string& number) {
    return read_json(
               "{'metaInformation':{'projectIdentification':'p','creator':'c','exportTimestamp':'t','lifVersion':'" +
               number + "'},'layouts':[" + layout_of(node_a + "," + node_b, edge_with("")) + "]}")
        .at("metaInformation.lifVersion");
  };
  EXPECT_EQ(version("1.9"), "");
  EXPECT_EQ(version("0.11.0"), "mended the file has version '0.11.0'; read as 1.0.0");
  EXPECT_EQ(version(std::string(50, '3')), "mended the file has version '" + std::string(40, '3') + "'; read as 1.0.0");
}

TEST(LifDocument, edge_rotation_is_none_any_or_one_way) {
  struct Row {
    std::string word;
    Rotation rotation;
    std::string diagnostic;
  };
  const std::string one_way =
      "lost turning in one direction only is not supported: vehicles turn in the shorter direction";
  for (const Row& row :
       {Row{"BOTH", Rotation::any, ""}, Row{"NONE", Rotation::none, ""}, Row{"CW", Rotation::one_way, one_way},
        Row{"CCW", Rotation::one_way, one_way},
        Row{"both", Rotation::any, "mended expected NONE, CW, CCW or BOTH, found 'both'; taken as BOTH"}}) {
    const Read start = with_properties("'rotationAtStartNodeAllowed':'" + row.word + "'");
    EXPECT_EQ(start.document->edges[0].leaving, row.rotation) << row.word;
    EXPECT_EQ(start.document->edges[0].arriving, Rotation::any) << row.word;
    EXPECT_EQ(start.at(properties_location + ".rotationAtStartNodeAllowed"), row.diagnostic);
    const Read end = with_properties("'rotationAtEndNodeAllowed':'" + row.word + "'");
    EXPECT_EQ(end.document->edges[0].arriving, row.rotation) << row.word;
    EXPECT_EQ(end.document->edges[0].leaving, Rotation::any) << row.word;
    EXPECT_EQ(end.at(properties_location + ".rotationAtEndNodeAllowed"), row.diagnostic);
  }
}

TEST(LifDocument, edge_properties_that_cannot_be_followed_are_lost) {
  struct Row {
    std::string member;
    std::string key;
    std::string diagnostic;
  };
  const std::string forwards = "lost another orientation than along the path is not supported: vehicles drive forwards";
  for (const Row& row : {
           Row{"'vehicleOrientation':0.0", "vehicleOrientation", ""},
           Row{"'vehicleOrientation':3.14", "vehicleOrientation", forwards},
           Row{"'vehicleOrientation':6.2831853", "vehicleOrientation", forwards},
           Row{"'vehicleOrientation':90", "vehicleOrientation", "mended an angle beyond ±2π must be meant in degrees"},
           Row{"'vehicleOrientation':-90", "vehicleOrientation", "mended an angle beyond ±2π must be meant in degrees"},
           Row{"'orientationType':'TANGENTIAL'", "vehicleOrientation", ""},
           Row{"'orientationType':'GLOBAL'", "vehicleOrientation", forwards},
           Row{"'maxRotationSpeed':1", "maxRotationSpeed",
               "lost 'maxRotationSpeed' is not taken: turns on the spot have one speed everywhere"},
           Row{"'minHeight':1", "minHeight", "lost 'minHeight' is not taken: a zone is flat"},
           Row{"'maxHeight':1", "maxHeight", "lost 'maxHeight' is not taken: a zone is flat"},
           Row{"'loadRestriction':{}", "loadRestriction",
               "lost 'loadRestriction' is not taken: vehicles drive here with and without load"},
           Row{"'actions':[]", "actions", "lost 'actions' is not taken: vehicles do nothing on edges but drive"},
           Row{"'reentryAllowed':true", "reentryAllowed", ""},
           Row{"'reentryAllowed':false", "reentryAllowed",
               "lost 'reentryAllowed' is not taken: vehicles do not turn round on edges anyway"},
           Row{"'maxSpeed':100", "maxSpeed", ""},
           Row{"'maxSpeed':100.5", "maxSpeed", "mended expected a positive speed of at most 100 m/s; taken as absent"},
           Row{"'maxSpeed':0", "maxSpeed", "mended expected a positive speed of at most 100 m/s; taken as absent"},
           Row{"'colour':1", "colour", "lost 'colour' is no field of LIF 1.0; not taken"},
       })
    EXPECT_EQ(with_properties(row.member).at(properties_location + "." + row.key), row.diagnostic) << row.member;
  EXPECT_EQ(with_properties("'maxSpeed':100").document->edges[0].speed_mps_max, 100.0);
}

TEST(LifDocument, edge_rotation_while_driving_is_lost_and_reported_where_it_is_missing) {
  const auto rotation = [](const std::string& member) {
    return read_json(whole(layout_of(node_a + "," + node_b,
                                     "{'edgeId':'A-B','startNodeId':'A','endNodeId':'B','vehicleTypeEdgeProperties':[{"
                                     "'vehicleTypeId':'T'" +
                                         member + "}]}")))
        .at(properties_location + ".rotationAllowed");
  };
  EXPECT_EQ(rotation(""), "mended 'rotationAllowed' is missing; vehicles do not turn on edges anyway");
  EXPECT_EQ(rotation(",'rotationAllowed':true"),
            "lost turning while driving is not supported: vehicles turn at nodes only");
  EXPECT_EQ(rotation(",'rotationAllowed':false"), "");
}

TEST(LifDocument, flags_in_another_form_are_taken_where_their_meaning_is_clear) {
  const auto reentry = [](const std::string& value) {
    return with_properties("'reentryAllowed':" + value).at(properties_location + ".reentryAllowed");
  };
  const std::string clear = "mended neither true nor false, but its meaning is clear";
  for (const char* value : {"'true'", "'True'", "'TRUE'", "1", "1.0", "'false'", "'False'", "'FALSE'", "0"})
    EXPECT_EQ(reentry(value), clear) << value;
  for (const char* value : {"'yes'", "2", "-1", "0.5", "[]", "{}"})
    EXPECT_EQ(reentry(value), "mended neither true nor false; taken as absent") << value;
  // And with its meaning: only false is reported as lost.
  const auto lost = [](const std::string& value) {
    const Read read = with_properties("'reentryAllowed':" + value);
    return std::any_of(read.diagnostics.begin(), read.diagnostics.end(),
                       [](const Diagnostic& d) { return d.kind == Diagnostic::Kind::lost; });
  };
  for (const char* value : {"'false'", "'False'", "'FALSE'", "0"}) EXPECT_TRUE(lost(value)) << value;
  for (const char* value : {"'true'", "'True'", "'TRUE'", "1", "'yes'", "2"}) EXPECT_FALSE(lost(value)) << value;
}

TEST(LifDocument, numbers_in_texts_are_taken_where_they_are_whole) {
  const auto x_of = [](const std::string& value) {
    const Read read = with_node("{'nodeId':'C','nodePosition':{'x':" + value + ",'y':0}}");
    return read.document->nodes.size() == 3 ? std::to_string(read.document->nodes[2].at.x_m) : "lost";
  };
  EXPECT_EQ(x_of("'0,55'"), "0.550000");
  EXPECT_EQ(x_of("'0.55'"), "0.550000");
  EXPECT_EQ(x_of("' +1.5 '"), "1.500000");
  EXPECT_EQ(x_of("'-2'"), "-2.000000");
  for (const char* value : {"''", "' '", "'1.5m'", "'m'", "'inf'", "'nan'", "'1e999'", "[1]", "{}", "true"})
    EXPECT_EQ(x_of(value), "lost") << value;
  EXPECT_EQ(with_node("{'nodeId':'C','nodePosition':{'x':'1','y':0}}").at("layouts[0].nodes[2].nodePosition.x"),
            "mended a text where a number belongs is taken as that number");
  EXPECT_EQ(with_node("{'nodeId':'C','nodePosition':{'x':[],'y':0}}").at("layouts[0].nodes[2].nodePosition.x"),
            "mended no number where one belongs; taken as absent");
  EXPECT_EQ(with_node("{'nodeId':1.5,'nodePosition':{'x':0,'y':5}}").document->nodes[2].id, "1.5");
  EXPECT_EQ(with_node("{'nodeId':7,'nodePosition':{'x':0,'y':5}}").at("layouts[0].nodes[2].nodeId"),
            "mended a number where a text belongs is taken as that text");
}

TEST(LifDocument, nodes_without_an_id_or_a_position_are_lost) {
  struct Row {
    std::string node;
    std::string key;
    std::string diagnostic;
  };
  for (const Row& row : {
           Row{"{'nodePosition':{'x':0,'y':0}}", "nodeId", "lost a node without an id; not taken"},
           Row{"{'nodeId':'','nodePosition':{'x':0,'y':0}}", "nodeId", "lost a node without an id; not taken"},
           Row{"{'nodeId':'C','nodePosition':{'x':0}}", "nodePosition", "lost a node without a position; not taken"},
           Row{"{'nodeId':'C','nodePosition':{'y':0}}", "nodePosition", "lost a node without a position; not taken"},
           Row{"{'nodeId':'C','nodePosition':[0,0]}", "nodePosition",
               "mended no object where one belongs; taken as absent"},
           Row{"{'nodeId':'C','nodePosition':{'x':1.1e9,'y':0}}", "nodePosition",
               "lost a node more than a million kilometres away; not taken"},
           Row{"{'nodeId':'C','nodePosition':{'x':0,'y':-1.1e9}}", "nodePosition",
               "lost a node more than a million kilometres away; not taken"},
       }) {
    const Read read = with_node(row.node);
    EXPECT_THAT(read.document->nodes, SizeIs(2)) << row.node;
    EXPECT_EQ(read.at("layouts[0].nodes[2]." + row.key), row.diagnostic) << row.node;
  }
  // A million kilometres exactly are read; the origin is then moved to the centre.
  EXPECT_THAT(with_node("{'nodeId':'C','nodePosition':{'x':1e9,'y':-1e9}}").document->nodes, SizeIs(3));
}

TEST(LifDocument, node_fields_that_a_zone_does_not_have_are_lost) {
  const Read read = with_node(
      "{'nodeId':'C','nodeName':'n','nodeDescription':'d','mapId':'other','nodePosition':{'x':1,'y':1,'z':0},"
      "'vehicleTypeNodeProperties':[{'vehicleTypeId':'T'}],'size':1}");
  const std::string at = "layouts[0].nodes[2].";
  EXPECT_EQ(read.at(at + "nodeName"), "lost 'nodeName' is not taken: a node is identified by its id");
  EXPECT_EQ(read.at(at + "nodeDescription"), "lost 'nodeDescription' is not taken: a node is identified by its id");
  EXPECT_EQ(read.at(at + "mapId"), "lost 'mapId' is not taken: in orders the map's id is the zone's name");
  EXPECT_EQ(read.at(at + "nodePosition.z"), "lost 'z' is no field of LIF 1.0; not taken");
  EXPECT_EQ(read.at(at + "size"), "lost 'size' is no field of LIF 1.0; not taken");
  // The project's own name is the zone's.
  EXPECT_EQ(with_node("{'nodeId':'C','mapId':'p','nodePosition':{'x':1,'y':1}}").at(at + "mapId"), "");
  EXPECT_EQ(with_node("{'nodeId':'C','nodePosition':{'x':1,'y':1}}").at(at + "vehicleTypeNodeProperties"),
            "mended no vehicle type is named; open to all");
}

TEST(LifDocument, ids_have_no_control_characters) {
  const Read read = with_node("{'nodeId':'C\\u0001\\u007f\\u001f ~','nodePosition':{'x':1,'y':1}}");
  EXPECT_EQ(read.document->nodes[2].id, "C    ~");
}

TEST(LifDocument, edges_without_an_id_are_named_after_their_nodes) {
  const std::string nameless = "{'startNodeId':'A','endNodeId':'B'}";
  const Read read = read_json(whole(layout_of(node_a + "," + node_b, edge_with("") + "," + nameless + "," + nameless)));
  ASSERT_TRUE(read.document) << read.error();
  ASSERT_THAT(read.document->edges, SizeIs(3));
  EXPECT_EQ(read.document->edges[1].id, "A-B'");
  EXPECT_EQ(read.document->edges[2].id, "A-B''");
  EXPECT_THAT(read.at("layouts[0].edges[1].edgeId"),
              HasSubstr("mended an edge without an id is named after its nodes, 'A-B' (2 times"));
  EXPECT_EQ(read_json(whole(layout_of(node_a + "," + node_b, "{'edgeId':'','startNodeId':'A','endNodeId':'B'}")))
                .document->edges[0]
                .id,
            "A-B");
}

TEST(LifDocument, edges_without_one_of_their_nodes_are_lost) {
  const auto edge = [](const std::string& text) {
    return read_json(whole(layout_of(node_a + "," + node_b, edge_with("") + "," + text)));
  };
  EXPECT_EQ(edge("{'edgeId':'e','endNodeId':'B'}").at("layouts[0].edges[1].startNodeId"),
            "lost an edge without a node that it starts at; not taken");
  EXPECT_EQ(edge("{'edgeId':'e','startNodeId':'B'}").at("layouts[0].edges[1].endNodeId"),
            "lost an edge without a node that it ends at; not taken");
  EXPECT_EQ(edge("{'edgeId':'e','startNodeId':'B','endNodeId':'" + std::string(70, 'z') + "'}")
                .at("layouts[0].edges[1].endNodeId"),
            "lost there is no node '" + std::string(64, 'z') + "' among those taken; not taken");
}

TEST(LifDocument, edge_names_are_taken_only_where_they_begin_the_id) {
  const auto named = [](const std::string& id, const std::string& name) {
    return read_json(whole(layout_of(
        node_a + "," + node_b, "{'edgeId':'" + id + "','edgeName':'" + name + "','startNodeId':'A','endNodeId':'B'}")));
  };
  EXPECT_EQ(named("X", "X").document->edges[0].section, "X");
  EXPECT_EQ(named("X.2", "X").document->edges[0].section, "X");
  EXPECT_EQ(named("X2", "X").document->edges[0].section, "");
  EXPECT_EQ(named("X2", "X").at("layouts[0].edges[0].edgeName"),
            "lost 'edgeName' is not taken: an edge is identified by its id");
  EXPECT_EQ(named("X", "X").at("layouts[0].edges[0].edgeName"), "");
  EXPECT_EQ(named("X", "").document->edges[0].section, "");
  EXPECT_EQ(read_json(whole(layout_of(node_a + "," + node_b, edge_with("", ",'edgeDescription':'d'"))))
                .at("layouts[0].edges[0].edgeDescription"),
            "lost 'edgeDescription' is not taken: an edge is identified by its id");
}

TEST(LifDocument, stations_have_a_name_nodes_and_a_kind) {
  const Read read = with_station(
      "{'stationId':'S','stationName':'dock','interactionNodeIds':['B','A'],'stationType':'CHARGING_POINT',"
      "'stationDescription':'d','stationHeight':1.5,'stationPosition':{'x':0,'y':0,'theta':0,'z':1},'colour':1}");
  ASSERT_THAT(read.document->stations, SizeIs(1));
  const Station& station = read.document->stations[0];
  EXPECT_EQ(station.id, "S");
  EXPECT_EQ(station.name, "dock");
  EXPECT_EQ(station.location, "layouts[0].stations[0]");
  EXPECT_THAT(station.nodes, ElementsAre(1, 0));
  EXPECT_TRUE(station.charges);
  const std::string at = "layouts[0].stations[0].";
  EXPECT_EQ(read.at(at + "stationType"),
            "mended 'stationType' is no field of LIF 1.0; used where it is CHARGING, otherwise ignored");
  EXPECT_EQ(read.at(at + "stationDescription"),
            "lost 'stationDescription' is not taken: a station is identified by its name");
  EXPECT_EQ(read.at(at + "stationHeight"), "lost 'stationHeight' is not taken: a zone is flat");
  EXPECT_EQ(read.at(at + "stationPosition"),
            "lost 'stationPosition' is not taken: a station lies where vehicles stop, at its interaction nodes");
  EXPECT_EQ(read.at(at + "stationPosition.z"), "lost 'z' is no field of LIF 1.0; not taken");
  EXPECT_EQ(read.at(at + "colour"), "lost 'colour' is no field of LIF 1.0; not taken");

  const Read plain = with_station("{'stationId':'S','interactionNodeIds':['B'],'stationType':'PICKUP'}");
  EXPECT_EQ(plain.document->stations[0].name, "S");
  EXPECT_FALSE(plain.document->stations[0].charges);
}

TEST(LifDocument, stations_without_an_id_or_an_object_are_lost) {
  EXPECT_EQ(with_station("{'interactionNodeIds':['B']}").at("layouts[0].stations[0].stationId"),
            "lost a station without an id; not taken");
  EXPECT_EQ(with_station("'S'").at("layouts[0].stations[0]"), "lost no object where a station belongs; not taken");
  EXPECT_EQ(with_station("{'stationId':'S','interactionNodeIds':'B'}").at("layouts[0].stations[0].interactionNodeIds"),
            "mended no list where one belongs; taken as absent");
  EXPECT_EQ(
      with_station("{'stationId':'S','interactionNodeIds':[[]]}").at("layouts[0].stations[0].interactionNodeIds[0]"),
      "mended no text where one belongs; taken as absent");
  EXPECT_THAT(with_station("{'stationId':'S','interactionNodeIds':[]}").diagnostics, IsEmpty());
}

TEST(LifDocument, a_single_object_is_a_list_of_one) {
  const Read read = read_json("{" + good_meta + ",'layouts':" + layout_of(node_a + "," + node_b, edge_with("")) + "}");
  ASSERT_TRUE(read.document) << read.error();
  EXPECT_THAT(read.at("layouts"), HasSubstr("mended a single object where a list belongs is taken as a list of one"));
  EXPECT_THAT(read.document->edges, SizeIs(1));
}

TEST(LifDocument, layouts_report_what_they_lack_and_what_a_zone_does_not_have) {
  const std::string nodes = "'nodes':[" + node_a + "," + node_b + "],'edges':[" + edge_with("") + "]";
  const Read bare = read_json(whole("{" + nodes + "}"));
  EXPECT_EQ(bare.at("layouts[0].layoutId"), "mended a layout without an id; taken all the same");
  EXPECT_EQ(bare.at("layouts[0].layoutVersion"), "mended 'layoutVersion' is missing; it is not needed");
  EXPECT_EQ(bare.at("layouts[0].stations"), "mended the list of stations is missing; there are none");
  const Read full = read_json(whole(layout_of(node_a + "," + node_b, edge_with(""), "",
                                              ",'layoutName':'n','layoutDescription':'d','layoutLevelId':'2','x':1")));
  EXPECT_EQ(full.at("layouts[0].layoutName"), "lost 'layoutName' is not taken: a zone has one name only");
  EXPECT_EQ(full.at("layouts[0].layoutDescription"), "lost 'layoutDescription' is not taken: a zone has none");
  EXPECT_EQ(full.at("layouts[0].x"), "lost 'x' is no field of LIF 1.0; not taken");
  EXPECT_EQ(full.document->layouts[0].level, "2");
  EXPECT_EQ(read_json(whole("3," + layout_of(node_a + "," + node_b, edge_with("")))).at("layouts[0]"),
            "lost no object where a layout belongs; not taken");
}

TEST(LifDocument, a_layout_is_selected_by_its_id_or_name) {
  const std::string other =
      "{'layoutId':'M','layoutName':'upper','layoutVersion':'1','nodes':[],'edges':[],'stations':[]}";
  const std::string both = whole(other + "," + layout_of(node_a + "," + node_b, edge_with("")));
  for (const char* name : {"M", "upper"}) {
    const Read read = read_json(both, {{}, name, 1.0});
    ASSERT_TRUE(read.document) << read.error();
    EXPECT_THAT(read.document->nodes, IsEmpty());
    EXPECT_EQ(read.at("layouts[1]"), "lost only the layout that [import] names is taken");
  }
  EXPECT_THAT(read_json(both, {{}, "L", 1.0}).document->nodes, SizeIs(2));
  EXPECT_THAT(read_json(both).document->layouts, SizeIs(2));
  EXPECT_EQ(read_json(both, {{}, "N", 1.0}).error(), "layouts: [import] layout is 'N', but this file has: M, L");
}

TEST(LifDocument, refuses_what_is_no_lif_at_all) {
  EXPECT_EQ(read_json("[]").error(), "expected an object with metaInformation and layouts");
  EXPECT_EQ(read_json("{}").error(), "layouts: expected a list of at least one layout, found none");
  EXPECT_EQ(read_json("{'layouts':[]}").error(), "layouts: expected a list of at least one layout, found none");
  EXPECT_THAT(read_json("{'origins':[],'layouts':[]}").error(),
              HasSubstr("origins: expected a list of at least one layout"));
}

TEST(LifDocument, takes_the_vehicle_type_with_most_edges_that_it_may_use) {
  const auto open_to = [](const std::string& types) {
    std::string list;
    for (const char type : types)
      list += (list.empty() ? "" : ",") + ("{'vehicleTypeId':'" + std::string(1, type)) + "'}";
    return "[" + list + "]";
  };
  const auto node = [&](const std::string& id, const std::string& x, const std::string& types) {
    return "{'nodeId':'" + id + "','nodePosition':{'x':" + x + ",'y':0},'vehicleTypeNodeProperties':" + open_to(types) +
           "}";
  };
  const auto edge = [&](const std::string& from, const std::string& to, const std::string& types) {
    return "{'edgeId':'" + from + to + "','startNodeId':'" + from + "','endNodeId':'" + to +
           "','vehicleTypeEdgeProperties':" + open_to(types) + "}";
  };
  const std::string nodes = node("A", "0", "ST") + "," + node("B", "1", "ST") + "," + node("C", "2", "S");
  // S has two edges; T three, of which it may reach one only.
  const std::string text = whole(layout_of(
      nodes, edge("A", "B", "S") + "," + edge("B", "A", "ST") + "," + edge("B", "C", "T") + "," + edge("C", "B", "T")));
  const Read read = read_json(text);
  EXPECT_EQ(read.document->edges.size(), 2U);
  EXPECT_EQ(read.document->edges[0].id, "AB");
  ASSERT_THAT(read.diagnostics, ::testing::Not(IsEmpty()));
  EXPECT_NE(std::find_if(read.diagnostics.begin(), read.diagnostics.end(),
                         [](const Diagnostic& d) {
                           return d.text ==
                                  "edges and properties are those of vehicle type 'S', one of 2; [import] vehicle_type "
                                  "in the sidecar file chooses another";
                         }),
            read.diagnostics.end());
  const Read other = read_json(text, {"T", {}, 1.0});
  EXPECT_EQ(other.document->edges.size(), 1U);
  EXPECT_EQ(other.document->edges[0].id, "BA");
  EXPECT_EQ(read_json(text, {"U", {}, 1.0}).error(), "layouts: [import] vehicle_type is 'U', but this file has: S, T");
}

/// Nodes a metre apart, each open to the types that its letters name, none for all: {"A", "S"}, {"B", ""} …
std::string nodes_open_to(const std::vector<std::pair<std::string, std::string>>& ids_and_types) {
  std::string text;
  std::size_t x = 0;
  for (const auto& [id, types] : ids_and_types) {
    std::string list;
    for (const char type : types)
      list += (list.empty() ? "{'vehicleTypeId':'" : ",{'vehicleTypeId':'") + std::string(1, type) + "'}";
    text += (text.empty() ? "{'nodeId':'" : ",{'nodeId':'") + id + "','nodePosition':{'x':" + std::to_string(x++) +
            ",'y':0}" + (list.empty() ? "" : ",'vehicleTypeNodeProperties':[" + list + "]") + "}";
  }
  return text;
}
/// The ids of the edges taken, of "AB", "CD" … from A to B, from C to D …, which name no vehicle type.
std::vector<std::string> edges_taken(const std::string& nodes, const std::vector<std::string>& edges) {
  std::string text;
  for (const std::string& edge : edges)
    text += (text.empty() ? "{'edgeId':'" : ",{'edgeId':'") + edge + "','startNodeId':'" + edge.substr(0, 1) +
            "','endNodeId':'" + edge.substr(1) + "'}";
  const Read read = read_json(whole(layout_of(nodes, text)));
  EXPECT_TRUE(read.document) << read.error();
  std::vector<std::string> ids;
  for (const Edge& edge : read.document->edges) ids.push_back(edge.id);
  return ids;
}

TEST(LifDocument, edges_that_name_no_vehicle_type_count_for_those_of_the_node_they_start_or_end_at) {
  // One edge for S, two for T.
  EXPECT_THAT(edges_taken(nodes_open_to({{"A", "S"}, {"B", ""}, {"C", "T"}, {"D", ""}}), {"AB", "CD", "CB"}),
              ElementsAre("CD", "CB"));
  EXPECT_THAT(edges_taken(nodes_open_to({{"A", ""}, {"B", "S"}, {"C", ""}, {"D", "T"}, {"E", ""}}), {"AB", "CD", "ED"}),
              ElementsAre("CD", "ED"));
  // As many for each: the first of the file.
  EXPECT_THAT(edges_taken(nodes_open_to({{"A", "S"}, {"B", ""}, {"C", "T"}, {"D", ""}}), {"CD", "AB"}),
              ElementsAre("AB"));
}

TEST(LifDocument, without_edges_closes_and_opens_nothing) {
  const Read read = read_json(whole(layout_of(node_a, "")));
  ASSERT_TRUE(read.document) << read.error();
  EXPECT_THAT(read.diagnostics, IsEmpty());
}

TEST(LifDocument, names_no_more_than_two_hundred_bytes_of_what_a_selection_could_have_been) {
  const auto layout = [](char id) {
    return "{'layoutId':'" + std::string(99, id) + "','nodes':[],'edges':[],'stations':[]}";
  };
  const std::string first_two = std::string(99, 'a') + ", " + std::string(99, 'b');
  EXPECT_EQ(read_json(whole(layout('a') + "," + layout('b') + "," + layout('c')), {{}, "x", 1.0}).error(),
            "layouts: [import] layout is 'x', but this file has: " + first_two);
  std::string types;
  for (const char type : {'a', 'b', 'c'})
    types += (types.empty() ? "{'vehicleTypeId':'" : ",{'vehicleTypeId':'") + std::string(99, type) + "'}";
  const std::string node = "{'nodeId':'A','nodePosition':{'x':0,'y':0},'vehicleTypeNodeProperties':[" + types + "]}";
  EXPECT_EQ(read_json(whole(layout_of(node, "")), {"x", {}, 1.0}).error(),
            "layouts: [import] vehicle_type is 'x', but this file has: " + first_two);
}

TEST(LifDocument, nodes_are_a_million_kilometres_away_in_metres_whatever_the_file_s_unit) {
  const auto nodes = [](const std::string& x, const std::string& y) {
    const std::string node = "{'nodeId':'C','nodePosition':{'x':" + x + ",'y':" + y + "}}";
    return read_json(whole(layout_of(node_a + "," + node_b + "," + node, edge_with(""))), {{}, {}, 0.5})
        .document->nodes.size();
  };
  EXPECT_EQ(nodes("1.9e9", "-1.9e9"), 3U);
  EXPECT_EQ(nodes("2.1e9", "0"), 2U);
  EXPECT_EQ(nodes("0", "-2.1e9"), 2U);
}

TEST(LifDocument, edge_properties_of_one_vehicle_type_are_taken_once) {
  const Read read = read_json(whole(
      layout_of(node_a + "," + node_b,
                "{'edgeId':'A-B','startNodeId':'A','endNodeId':'B','vehicleTypeEdgeProperties':[{'vehicleTypeId':'T',"
                "'rotationAllowed':false,'maxSpeed':1},{'vehicleTypeId':'T','maxSpeed':2},{'vehicleTypeId':'T','"
                "maxSpeed':3}]}")));
  EXPECT_EQ(read.document->edges[0].speed_mps_max, 1.0);
  ASSERT_THAT(read.diagnostics, SizeIs(1));
  EXPECT_EQ(read.at("layouts[0].edges[0].vehicleTypeEdgeProperties[1]"),
            "lost the vehicle type's properties a second time; not taken (2 times, also at "
            "layouts[0].edges[0].vehicleTypeEdgeProperties[2])");
}

TEST(LifDocument, angles_beyond_a_full_turn_are_taken_for_degrees) {
  const std::string degrees = "mended an angle beyond ±2π must be meant in degrees";
  const std::string forwards = "lost another orientation than along the path is not supported: vehicles drive forwards";
  const std::string heading = "lost 'theta' is not taken: a stopped vehicle has the heading of its path";
  for (const auto& [angle, is_beyond] : {std::pair{"1", false},
                                         {"-1", false},
                                         {"6.2831853", false},
                                         {"-6.2831853", false},
                                         {"6.29", true},
                                         {"-6.29", true}}) {
    EXPECT_EQ(
        with_properties(std::string("'vehicleOrientation':") + angle).at(properties_location + ".vehicleOrientation"),
        is_beyond ? degrees : forwards)
        << angle;
    EXPECT_EQ(with_node("{'nodeId':'C','nodePosition':{'x':1,'y':1},'vehicleTypeNodeProperties':[{'vehicleTypeId':'T',"
                        "'theta':" +
                        std::string(angle) + "}]}")
                  .at("layouts[0].nodes[2].vehicleTypeNodeProperties[0].theta"),
              is_beyond ? degrees : heading)
        << angle;
  }
}

TEST(LifDocument, nodes_offer_charging_and_no_other_action) {
  const std::string at = "layouts[0].nodes[2].vehicleTypeNodeProperties[0].actions";
  const std::string others = "lost 'actions' is not taken: vehicles do nothing at nodes but stop, turn and charge";
  struct Row {
    std::string actions;
    bool charges;
    std::string diagnostic;
  };
  for (const Row& row :
       {Row{"", false, ""}, Row{"{'actionType':'startCharging'}", true, ""},
        Row{"{'actionType':'stopCharging'}", false, ""},
        Row{"{'actionType':'stopCharging'},{'actionType':'startCharging'}", true, ""},
        Row{"{'actionType':'pick'}", false, others},
        Row{"{'actionType':'pick'},{'actionType':'startCharging'}", true, others}, Row{"{}", false, others}}) {
    const Read read = with_node(
        "{'nodeId':'C','nodePosition':{'x':1,'y':1},'vehicleTypeNodeProperties':[{'vehicleTypeId':'T','actions':[" +
        row.actions + "]}]}");
    EXPECT_EQ(read.document->nodes[2].charges, row.charges) << row.actions;
    EXPECT_EQ(read.at(at), row.diagnostic) << row.actions;
  }
}

TEST(LifDocument, a_permission_to_turn_that_is_no_flag_counts_as_none) {
  const Read read = read_json(whole(
      layout_of(node_a + "," + node_b,
                "{'edgeId':'A-B','startNodeId':'A','endNodeId':'B','vehicleTypeEdgeProperties':[{'vehicleTypeId':'T',"
                "'rotationAllowed':'maybe'}]}")));
  ASSERT_THAT(read.diagnostics, SizeIs(1));
  EXPECT_EQ(read.at(properties_location + ".rotationAllowed"), "mended neither true nor false; taken as absent");
}

TEST(LifDocument, names_of_unknown_fields_are_cut_to_64_bytes) {
  const std::string cut(64, 'k');
  EXPECT_EQ(with_properties("'" + cut + "kk':1").at(properties_location + "." + cut),
            "lost '" + cut + "' is no field of LIF 1.0; not taken");
}

TEST(LifDocument, moves_the_origin_to_the_centre_where_one_node_is_far_away) {
  const auto moved = [](Point2 a, Point2 b) {
    const auto node = [](const char* id, Point2 at) {
      return "{'nodeId':'" + std::string(id) + "','nodePosition':{'x':" + std::to_string(at.x_m) +
             ",'y':" + std::to_string(at.y_m) + "}}";
    };
    const Read read = read_json(whole(layout_of(node("A", a) + "," + node("B", b), edge_with(""))));
    return std::pair{read.document->nodes[0].at, read.document->nodes[1].at};
  };
  using Two = std::pair<Point2, Point2>;
  EXPECT_EQ(moved({0.0, 0.0}, {150000.0, 0.0}), (Two{{-75000.0, 0.0}, {75000.0, 0.0}}));
  EXPECT_EQ(moved({150000.0, 8.0}, {0.0, 0.0}), (Two{{75000.0, 8.0}, {-75000.0, 0.0}}));
  EXPECT_EQ(moved({0.0, 0.0}, {-150000.0, 0.0}), (Two{{75000.0, 0.0}, {-75000.0, 0.0}}));
  EXPECT_EQ(moved({0.0, 0.0}, {0.0, 150000.0}), (Two{{0.0, -75000.0}, {0.0, 75000.0}}));
  EXPECT_EQ(moved({0.0, -150000.0}, {8.0, 0.0}), (Two{{0.0, -75000.0}, {8.0, 75000.0}}));
  EXPECT_EQ(moved({0.0, 0.0}, {90000.0, -90000.0}), (Two{{0.0, 0.0}, {90000.0, -90000.0}}));
}

TEST(LifDocument, moves_trajectories_with_the_origin) {
  const std::string nodes =
      "{'nodeId':'A','nodePosition':{'x':3500000,'y':-200000}},{'nodeId':'B','nodePosition':{'x':3500004,'y':-200000}}";
  const Read read = read_json(whole(layout_of(
      nodes,
      edge_with(",'trajectory':{'degree':2,'knotVector':[0,0,0,1,1,1],'controlPoints':[{'x':3500000,'y':-200000},"
                "{'x':3500002,'y':-199999},{'x':3500004,'y':-200000}]}"))));
  ASSERT_TRUE(read.document->edges[0].trajectory);
  EXPECT_THAT(read.document->edges[0].trajectory->points,
              ElementsAre(Point2{0.0, 0.0}, Point2{2.0, 1.0}, Point2{4.0, 0.0}));
  EXPECT_EQ(read.at("layouts"),
            "mended coordinates beyond 100 km: the zone's origin is the file's (3500000 m, -200000 m)");
}

TEST(LifDocument, moves_an_origin_beyond_a_hundred_kilometres) {
  const auto at = [](const std::string& x, const std::string& y) {
    return read_json(whole(layout_of("{'nodeId':'A','nodePosition':{'x':" + x + ",'y':" + y +
                                         "}},{'nodeId':'B','nodePosition':{'x':" + x + ",'y':" + y + "}}",
                                     "{'edgeId':'e','startNodeId':'A','endNodeId':'B'}")))
        .document->nodes[0]
        .at;
  };
  EXPECT_EQ(at("100000", "-100000"), (Point2{100000.0, -100000.0}));
  EXPECT_EQ(at("100000.5", "0"), (Point2{0.5, 0.0}));
  EXPECT_EQ(at("0", "-100400"), (Point2{0.0, -400.0}));
  EXPECT_EQ(at("-250000", "7"), (Point2{0.0, 7.0}));
}

}  // namespace
}  // namespace cosiva::zone::lif
