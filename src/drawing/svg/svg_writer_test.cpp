#include "cosiva/drawing/svg/svg_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace cosiva::drawing {
namespace {

TEST(Readable, prints_no_insignificant_digits) {
  EXPECT_EQ(readable(1.5), "1.5");
  EXPECT_EQ(readable(2.0), "2");
  EXPECT_EQ(readable(100.0), "100");
  EXPECT_EQ(readable(100.0, 0), "100");
  EXPECT_EQ(readable(0.12345, 2), "0.12");
  EXPECT_EQ(readable(-0.0001), "0");
  EXPECT_EQ(readable(2.5e15), "2.500e+15");
  EXPECT_EQ(readable(std::nan("")), "–");
}

TEST(Escaped, keeps_line_ends_and_leaves_out_what_xml_cannot_express) {
  EXPECT_EQ(escaped("a<b>&\"c\""), "a&lt;b&gt;&amp;&quot;c&quot;");
  EXPECT_EQ(escaped("a\tb\r\nc"), "a\tb\r\nc");
  EXPECT_EQ(escaped(std::string_view{"a\0b\x1b", 4}), "ab");
  EXPECT_EQ(escaped("grün"), "grün");
}

TEST(ColourBetween, passes_through_each_stop) {
  constexpr std::array<Rgb, 3> stops{{{0, 0, 0}, {255, 100, 0}, {255, 255, 255}}};
  EXPECT_EQ(colour_between(stops, 0.0), "#000000");
  EXPECT_EQ(colour_between(stops, 0.25), "#803200");
  EXPECT_EQ(colour_between(stops, 0.5), "#ff6400");
  EXPECT_EQ(colour_between(stops, 1.0), "#ffffff");
  EXPECT_EQ(colour_between(stops, -1.0), "#000000");
  EXPECT_EQ(colour_between(stops, 7.0), "#ffffff");
}

TEST(SvgWriter, nests_elements_and_ends_each_of_them) {
  SvgWriter svg{2};
  svg.open("svg").attribute("viewBox", {0.0, 0.0, 10.0, 2.5}).title("a & b");
  svg.open("g").attribute("fill", "none").title("group");
  svg.shape("rect").at(1.0, 2.005).size(3.14159, -0.001);
  svg.shape("circle").attribute("r", 3.0).title("<x>");
  svg.close().shape("text").text("one").text(" two");
  svg.close();
  EXPECT_EQ(svg.take(),
            "<svg viewBox=\"0 0 10 2.5\">\n"
            "<title>a &amp; b</title>\n"
            "<g fill=\"none\">\n"
            "<title>group</title>\n"
            "<rect x=\"1\" y=\"2\" width=\"3.14\" height=\"0\"/>\n"
            "<circle r=\"3\"><title>&lt;x&gt;</title></circle>\n"
            "</g>\n"
            "<text>one two</text>\n"
            "</svg>\n");
  EXPECT_EQ(svg.take(), "");
}

TEST(SvgWriter, escapes_the_values_of_attributes) {
  SvgWriter svg{0};
  svg.shape("path").attribute("aria-label", "\"<a>\"");
  EXPECT_EQ(svg.take(), "<path aria-label=\"&quot;&lt;a&gt;&quot;\"/>\n");
}

TEST(SvgWriterDeathTest, refuses_what_would_not_be_a_drawing) {
  SvgWriter svg{1};
  EXPECT_DEATH(svg.attribute("x", 1.0), "");
  EXPECT_DEATH(svg.text("outside"), "");
  EXPECT_DEATH(svg.close(), "");
  svg.open("g");
  EXPECT_DEATH((void)svg.take(), "");
}

}  // namespace
}  // namespace cosiva::drawing
