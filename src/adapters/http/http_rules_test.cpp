#include "cosiva/adapters/http/http_rules.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters::http_rules {
namespace {

using adapters::testing::Scratch;

TEST(Authority, is_a_host_with_or_without_a_port) {
  for (const char* good : {"localhost", "plant-4.example:8080", "127.0.0.1:1", "[::1]", "[::1]:65535"})
    EXPECT_TRUE(is_authority(good)) << good;
  for (const char* bad : {"", ":80", "h:", "h:0", "h:65536", "h:8x", "me@h", "h/", "h?", "h h", "[::1", "[x]", "::1"})
    EXPECT_FALSE(is_authority(bad)) << bad;
}

TEST(Host, is_own_only_by_a_loopback_name) {
  for (const char* own : {"localhost", "LocalHost:8080", "127.0.0.1", "127.0.0.1:9", "[::1]", "[::1]:8080"})
    EXPECT_TRUE(is_loopback_authority(own)) << own;
  for (const char* other : {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example:8080", "localhost:",
                            "localhost:80x", "[::1", "[::1]x", "127.0.0.2", "10.0.0.1:8080", "user@localhost"})
    EXPECT_FALSE(is_loopback_authority(other)) << other;
}

TEST(Origin, is_own_only_with_our_port_or_as_the_requested_host) {
  EXPECT_TRUE(is_own_origin("http://localhost:8080", "127.0.0.1:8080", 8080));
  EXPECT_TRUE(is_own_origin("http://127.0.0.1:8080", "localhost:8080", 8080));
  EXPECT_TRUE(is_own_origin("http://localhost", "localhost", 80));
  EXPECT_TRUE(is_own_origin("http://localhost:5173", "localhost:5173", 8080));  // through a development server
  for (const char* other : {"null", "", "http://localhost:8081", "https://localhost:8080", "http://evil.example:8080",
                            "http://localhost:8080.evil.example", "http://localhost"})
    EXPECT_FALSE(is_own_origin(other, "localhost:8080", 8080)) << other;
  EXPECT_FALSE(is_own_origin("http://evil.example", "evil.example", 8080));
}

TEST(Path, is_decoded_once) {
  EXPECT_EQ(clean_path("/assets/a%20b.js"), "/assets/a b.js");
  EXPECT_EQ(clean_path("/%252e%252e/x"), "/%2e%2e/x");
  EXPECT_EQ(clean_path("/a..b/.c"), "/a..b/.c");
}

TEST(Path, that_leads_out_of_the_root_or_is_malformed_is_refused) {
  for (const char* bad : {"", "x", "/..", "/../etc/passwd", "/a/../../b", "/%2e%2e/etc/passwd", "/%2E./x", "/..%2fx",
                          "/a/.", "/%", "/%4", "/%zz", "/a%00b", "/..\\x", "/%5c..%5cx", "http://evil/"})
    EXPECT_FALSE(clean_path(bad)) << bad;
}

TEST(Segments, are_split_before_they_are_decoded) {
  using ::testing::ElementsAre;
  EXPECT_THAT(*path_segments("/api/v1/virtual-objects/P1"), ElementsAre("api", "v1", "virtual-objects", "P1"));
  EXPECT_THAT(*path_segments("/api/v1/virtual-objects/CoSiVA.virtual%2FV1"),
              ElementsAre("api", "v1", "virtual-objects", "CoSiVA.virtual/V1"));
  EXPECT_THAT(*path_segments("/a%252Fb/c%20d/"), ElementsAre("a%2Fb", "c d"));
  EXPECT_THAT(*path_segments("/api%2Fv1/zone"), ElementsAre("api/v1", "zone"));
  EXPECT_THAT(*path_segments("/a//b"), ElementsAre("a", "", "b"));
  EXPECT_TRUE(path_segments("/")->empty());
}

TEST(Segments, that_lead_out_of_the_root_or_are_malformed_are_refused) {
  for (const char* bad :
       {"", "x", "%2Fx", "/..", "/a/%2e%2e/b", "/a/..%2Fb", "/a/x%2F..%2Fb", "/a/%2", "/a/%00", "/a\\b"})
    EXPECT_FALSE(path_segments(bad)) << bad;
}

TEST(Json, is_recognised_by_its_media_type) {
  for (const char* good :
       {"application/json", "Application/JSON", "application/json; charset=utf-8", "application/json ;x"})
    EXPECT_TRUE(is_json(good)) << good;
  for (const char* bad : {"", "text/plain", "application/x-www-form-urlencoded", "application/json5", "json"})
    EXPECT_FALSE(is_json(bad)) << bad;
}

TEST(RateLimit, permits_a_burst_and_then_its_rate) {
  using namespace std::chrono_literals;
  RateLimit::Time now{};
  RateLimit limit{200.0, 400.0, now};
  const auto passed = [&](int requested) {
    int count = 0;
    for (int i = 0; i < requested; ++i) count += limit.take(now) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(passed(1000), 400);
  now += 500ms;
  EXPECT_EQ(passed(1000), 100);
  now += 1h;  // a long pause saves up no more than a burst
  EXPECT_EQ(passed(1000), 400);
  now -= 1s;  // a clock that went back changes nothing
  EXPECT_EQ(passed(10), 0);
}

TEST(Mime, follows_the_ending) {
  EXPECT_EQ(mime_type("/index.html"), "text/html; charset=utf-8");
  EXPECT_EQ(mime_type("/assets/x.js"), "text/javascript; charset=utf-8");
  EXPECT_EQ(mime_type("/style.css"), "text/css; charset=utf-8");
  EXPECT_EQ(mime_type("/icon.svg"), "image/svg+xml");
  EXPECT_EQ(mime_type("/noending"), "application/octet-stream");
}

TEST(StaticFile, is_found_below_the_root_and_nowhere_else) {
  Scratch scratch;
  const std::string root = scratch / "web";
  scratch.write("web/index.html", "<p>hi</p>");
  scratch.write("web/assets/a.js", "1");
  scratch.write("secret", "no");
  scratch.write("web-evil/x", "no");
  std::filesystem::create_symlink("../secret", root + "/leak");
  std::filesystem::create_symlink("../web-evil/x", root + "/leak2");
  EXPECT_EQ(load_static(root, "/").value().bytes, "<p>hi</p>");
  EXPECT_EQ(load_static(root, "/assets/a.js").value().bytes, "1");
  for (const char* no : {"/none", "/assets", "/assets/", "/leak", "/leak2", "//etc/passwd", "/../secret"})
    EXPECT_FALSE(load_static(root, no)) << no;
  EXPECT_FALSE(load_static(scratch / "nowhere", "/"));
}

TEST(StaticFile, tag_changes_with_the_file_and_is_recognised) {
  Scratch scratch;
  scratch.write("index.html", "one");
  const auto first = load_static(scratch.path(), "/").value();
  EXPECT_TRUE(etag_matches(first.etag, first.etag));
  EXPECT_TRUE(etag_matches("\"x\", W/" + first.etag, first.etag));
  EXPECT_TRUE(etag_matches("*", first.etag));
  EXPECT_FALSE(etag_matches("\"x\"", first.etag));
  EXPECT_FALSE(etag_matches("", first.etag));
  scratch.write("index.html", "longer");
  EXPECT_NE(load_static(scratch.path(), "/").value().etag, first.etag);
}

}  // namespace
}  // namespace cosiva::adapters::http_rules
