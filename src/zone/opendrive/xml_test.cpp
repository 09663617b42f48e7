#include "cosiva/zone/opendrive/xml.h"

#include <gmock/gmock.h>

#include <optional>
#include <string>

namespace cosiva::zone::opendrive {
namespace {

using ::testing::HasSubstr;

constexpr Range metres_range{"metres from -10 to 20.5", -10.0, 20.5};

std::unique_ptr<XmlFile> parsed_file(std::string_view text) {
  auto file = XmlFile::parse("a.xodr", text);
  EXPECT_TRUE(file) << to_string(file.error());
  return std::move(*file);
}
std::unique_ptr<XmlFile> with_value(const std::string& value) { return parsed_file("<a v=\"" + value + "\"/>"); }

std::string fault_of(const XmlFile& file) { return file.error() ? to_string(*file.error()) : "none"; }

TEST(XmlNumber, is_read_within_its_range_including_both_bounds) {
  const std::pair<const char*, double> good[] = {{"-10", -10.0},   {"20.5", 20.5}, {"+1.5", 1.5}, {" \t3\r\n", 3.0},
                                                 {"-0.25", -0.25}, {"2e1", 20.0},  {".5", 0.5},   {"1e-999", 0.0},
                                                 {"1E-999", 0.0},  {"0", 0.0},     {"+7.", 7.0}};
  for (const auto& [text, value] : good) {
    const auto file = with_value(text);
    EXPECT_EQ(file->number(file->root(), "v", metres_range), value) << text;
    EXPECT_FALSE(file->error()) << text << ": " << fault_of(*file);
  }
}

TEST(XmlNumber, that_is_none_or_out_of_range_is_a_fault_and_reads_as_the_lower_bound) {
  for (const char* text : {"-10.001", "20.501", "+-1", "++1", "+", "", " ", "1,5", "1 2", "0x10", "inf", "-inf", "nan",
                           "1e999", "1E999", "two"}) {
    const auto file = with_value(text);
    EXPECT_EQ(file->number(file->root(), "v", metres_range, 3.0), -10.0) << text;
    ASSERT_TRUE(file->error()) << text;
    EXPECT_EQ(file->error()->code, "zone.field") << text;
    EXPECT_EQ(file->error()->message, "expected metres from -10 to 20.5, found \"" + std::string(text) + "\"");
    EXPECT_EQ(file->error()->location, "a.xodr:1: /@v");
  }
}

TEST(XmlNumber, that_is_missing_is_its_fallback_or_a_fault) {
  const auto file = parsed_file("<a/>");
  EXPECT_EQ(file->number(file->root(), "v", metres_range, 3.0), 3.0);
  EXPECT_FALSE(file->error());
  EXPECT_EQ(file->number(file->root(), "v", metres_range), -10.0);
  ASSERT_TRUE(file->error());
  EXPECT_EQ(file->error()->code, "zone.missing");
  EXPECT_EQ(file->error()->message, "expected metres from -10 to 20.5, found nothing");
}

TEST(XmlWhole, is_a_whole_number_up_to_a_million) {
  const std::pair<const char*, int> good[] = {{"-3", -3}, {"4.0", 4}, {"1000000", 1000000}, {"-1000000", -1000000}};
  for (const auto& [text, value] : good) {
    const auto file = with_value(text);
    EXPECT_EQ(file->whole(file->root(), "v"), value) << text;
    EXPECT_FALSE(file->error()) << text;
  }
  for (const char* text : {"1000001", "-1000001", "2.5", "", "one"}) {
    const auto file = with_value(text);
    EXPECT_EQ(file->whole(file->root(), "v"), std::nullopt) << text;
    ASSERT_TRUE(file->error()) << text;
    EXPECT_EQ(file->error()->code, "zone.field");
    EXPECT_EQ(file->error()->message, "expected a whole number, found \"" + std::string(text) + "\"");
  }
  const auto file = with_value("1");
  EXPECT_EQ(file->whole(file->root(), "w"), std::nullopt);
  EXPECT_FALSE(file->error());
}

TEST(XmlId, has_1_to_128_printable_bytes) {
  for (const std::string& text : {std::string("x"), std::string(128, 'i'), std::string("a b"), std::string("é")}) {
    const auto file = with_value(text);
    EXPECT_EQ(file->id(file->root(), "v"), text);
    EXPECT_FALSE(file->error()) << text;
  }
  const auto blank = with_value("  7 ");
  EXPECT_EQ(blank->id(blank->root(), "v"), "7");
  const struct {
    std::string text;
    const char* code;
    std::string found;
  } bad[] = {{std::string(129, 'i'), "zone.field", '"' + std::string(40, 'i') + "…\""},
             {"a&#31;b", "zone.field", "\"a b\""},
             {"", "zone.missing", "nothing"},
             {"  ", "zone.missing", "nothing"}};
  for (const auto& [text, code, found] : bad) {
    const auto file = with_value(text);
    EXPECT_EQ(file->id(file->root(), "v"), "?");
    ASSERT_TRUE(file->error()) << text;
    EXPECT_EQ(file->error()->code, code);
    EXPECT_EQ(file->error()->message, "expected an id of 1 to 128 characters, found " + found);
  }
}

TEST(XmlFault, quotes_at_most_forty_characters) {
  const auto whole = with_value(std::string(40, 'q'));
  (void)whole->number(whole->root(), "v", metres_range);
  EXPECT_THAT(fault_of(*whole), HasSubstr('"' + std::string(40, 'q') + '"'));
  const auto cut = with_value(std::string(41, 'q'));
  (void)cut->number(cut->root(), "v", metres_range);
  EXPECT_THAT(fault_of(*cut), HasSubstr('"' + std::string(40, 'q') + "…\""));
}

TEST(XmlFault, that_comes_first_is_kept) {
  const auto file = with_value("x");
  file->fault(file->root(), {}, "first", "one");
  file->fault(file->root(), "v", "second", "two");
  ASSERT_TRUE(file->error());
  EXPECT_EQ(file->error()->code, "first");
  EXPECT_EQ(file->error()->message, "one");
  EXPECT_EQ(file->error()->location, "a.xodr:1");
}

TEST(XmlPath, names_roads_and_lanes_by_id_and_others_by_their_number) {
  const std::string long_id(41, 'r');
  const auto file =
      parsed_file("<o>\n<road id=\"7\"><g/><g/>\n<g x=\"1\"/><h/></road><road/>\n<junction id=\"" + long_id +
                  "\"><lane id=\"-123456789012\"/><lane/></junction>\n<station id=\"9\"/>\n</o>");
  const auto root = file->root();
  const auto road = root.child("road");
  EXPECT_EQ(XmlFile::path(root), "");
  EXPECT_EQ(XmlFile::path(root, "v"), "/@v");
  EXPECT_EQ(XmlFile::path(road), "road 7");
  EXPECT_EQ(XmlFile::path(road, "length"), "road 7, @length");
  EXPECT_EQ(XmlFile::path(road.next_sibling()), "road[2]");
  EXPECT_EQ(XmlFile::path(road.first_child()), "road 7, g[1]");
  EXPECT_EQ(XmlFile::path(road.first_child().next_sibling()), "road 7, g[2]");
  EXPECT_EQ(XmlFile::path(road.child("h"), "x"), "road 7, h/@x");
  const auto junction = root.child("junction");
  EXPECT_EQ(XmlFile::path(junction), "junction " + long_id.substr(0, 40));
  EXPECT_EQ(XmlFile::path(junction.first_child()), "junction " + long_id.substr(0, 40) + ", lane[-12345678901]");
  EXPECT_EQ(XmlFile::path(junction.last_child()), "junction " + long_id.substr(0, 40) + ", lane[2]");
  EXPECT_EQ(XmlFile::path(root.child("station")), "station");
  EXPECT_EQ(file->location(road.find_child_by_attribute("g", "x", "1"), "x"), "a.xodr:3: road 7, g[3]/@x");
  EXPECT_EQ(file->location(root), "a.xodr:1");
  EXPECT_EQ(file->location(root.child("station")), "a.xodr:5: station");
}

TEST(XmlParse, counts_lines_only_where_bytes_are_characters) {
  for (const char* encoding : {"ISO-8859-1", "latin1"}) {
    const std::string text = "<?xml version=\"1.0\" encoding=\"" + std::string(encoding) + "\"?>\n<o>\n<a/></o>";
    const auto file = parsed_file(text);
    EXPECT_EQ(file->location(file->root().first_child()), "a.xodr: a") << encoding;
    const auto bad = XmlFile::parse("a.xodr", text + "<");
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().code, "zone.syntax");
    EXPECT_EQ(bad.error().location, "a.xodr") << encoding;
  }
  const auto bad = XmlFile::parse("a.xodr", "<o>\n\n<a></b></o>");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().code, "zone.syntax");
  EXPECT_THAT(bad.error().message, HasSubstr("cannot be read as XML: "));
  EXPECT_EQ(bad.error().location, "a.xodr:3");
}

TEST(XmlParse, limits_bytes_elements_and_attributes) {
  const auto code_of = [](const std::string& text) { return XmlFile::parse("a.xodr", text).error().code; };
  EXPECT_EQ(code_of(std::string(8'000'000, '=')), "zone.syntax");
  EXPECT_EQ(code_of(std::string(8'000'001, '=')), "zone.size");
  EXPECT_EQ(code_of(std::string(2'000'000, '<')), "zone.syntax");
  EXPECT_EQ(code_of(std::string(2'000'001, '<')), "zone.size");
}

TEST(XmlParse, takes_64_MiB_and_no_more) {
  std::string text = "<a/>";
  text.resize(std::size_t{64} << 20U, ' ');
  EXPECT_TRUE(XmlFile::parse("a.xodr", text));
  text += ' ';
  const auto more = XmlFile::parse("a.xodr", text);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, "zone.size");
  EXPECT_EQ(more.error().message, "expected at most 64 MiB, found 67108865 bytes");
}

}  // namespace
}  // namespace cosiva::zone::opendrive
