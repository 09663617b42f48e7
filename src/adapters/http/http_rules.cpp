#include "cosiva/adapters/http/http_rules.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <boost/url/authority_view.hpp>
#include <boost/url/grammar/ci_string.hpp>
#include <boost/url/pct_string_view.hpp>
#include <filesystem>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/base/expect.h"

namespace cosiva::adapters::http_rules {
namespace {

namespace urls = boost::urls;

/// HOST or HOST:PORT; nothing for a user, or for a colon without a port.
std::optional<urls::authority_view> host_and_port(std::string_view text) {
  const auto parsed = urls::parse_authority(text);
  if (!parsed || parsed->has_userinfo() || (parsed->has_port() && parsed->port().empty())) return std::nullopt;
  return *parsed;
}

/// Percent-decoded; nothing for bad escapes, a NUL or a backslash.
std::optional<std::string> decoded(std::string_view raw) {
  const auto checked = urls::make_pct_string_view(raw);
  if (!checked) return std::nullopt;
  std::string text = checked->decode();
  if (text.find('\0') != std::string::npos || text.find('\\') != std::string::npos) return std::nullopt;
  return text;
}

bool has_dot_segment(std::string_view path) {
  while (!path.empty()) {
    const std::size_t slash = std::min(path.find('/'), path.size());
    const std::string_view segment = path.substr(0, slash);
    if (segment == "." || segment == "..") return true;
    path.remove_prefix(std::min(slash + 1, path.size()));
  }
  return false;
}

}  // namespace

bool is_authority(std::string_view text) {
  const auto authority = host_and_port(text);
  return authority && !authority->encoded_host().empty() && (!authority->has_port() || authority->port_number() != 0);
}

bool is_loopback_authority(std::string_view text) {
  const auto authority = host_and_port(text);
  if (!authority) return false;
  const std::string_view host = authority->encoded_host();
  return urls::grammar::ci_is_equal(host, "localhost") || host == "127.0.0.1" || host == "[::1]";
}

bool is_own_origin(std::string_view origin, std::string_view host, std::uint16_t port) {
  constexpr std::string_view scheme = "http://";
  if (!origin.starts_with(scheme)) return false;
  origin.remove_prefix(scheme.size());
  if (!is_loopback_authority(origin)) return false;
  if (urls::grammar::ci_is_equal(origin, host)) return true;
  const std::string_view own_port = host_and_port(origin)->port();
  return (own_port.empty() ? "80" : own_port) == std::to_string(port);
}

std::optional<std::string> clean_path(std::string_view raw) {
  auto path = decoded(raw);
  if (!path || !path->starts_with('/') || has_dot_segment(*path)) return std::nullopt;
  return path;
}

std::optional<std::vector<std::string>> path_segments(std::string_view raw) {
  if (!clean_path(raw) || !raw.starts_with('/')) return std::nullopt;
  std::vector<std::string> segments;
  // Split first, then decoded: a decoded slash is part of a name.
  for (raw.remove_prefix(1); !raw.empty();) {
    const std::size_t slash = std::min(raw.find('/'), raw.size());
    segments.push_back(*decoded(raw.substr(0, slash)));
    raw.remove_prefix(std::min(slash + 1, raw.size()));
  }
  return segments;
}

bool changes_state(std::string_view method) { return method != "GET" && method != "HEAD"; }

bool is_json(std::string_view content_type) {
  std::string_view type = content_type.substr(0, content_type.find(';'));
  while (type.ends_with(' ')) type.remove_suffix(1);
  return urls::grammar::ci_is_equal(type, "application/json");
}

bool RateLimit::take(Time now) {
  const double rested_s = std::chrono::duration<double>(now - at_).count();
  left_ = std::min(burst_, left_ + std::max(rested_s, 0.0) * per_second_);
  at_ = now;
  if (left_ < 1.0) return false;
  left_ -= 1.0;
  COSIVA_EXPECT(left_ >= 0.0 && left_ <= burst_);
  return true;
}

std::string_view mime_type(std::string_view path) {
  using Entry = std::pair<std::string_view, std::string_view>;
  static constexpr std::array types{
      Entry{".html", "text/html; charset=utf-8"},
      Entry{".js", "text/javascript; charset=utf-8"},
      Entry{".mjs", "text/javascript; charset=utf-8"},
      Entry{".css", "text/css; charset=utf-8"},
      Entry{".json", "application/json"},
      Entry{".map", "application/json"},
      Entry{".webmanifest", "application/manifest+json"},
      Entry{".svg", "image/svg+xml"},
      Entry{".png", "image/png"},
      Entry{".jpg", "image/jpeg"},
      Entry{".ico", "image/vnd.microsoft.icon"},
      Entry{".webp", "image/webp"},
      Entry{".woff2", "font/woff2"},
      Entry{".wasm", "application/wasm"},
      Entry{".txt", "text/plain; charset=utf-8"},
  };
  for (const auto& [ending, type] : types) {
    if (path.ends_with(ending)) return type;
  }
  return "application/octet-stream";
}

Result<StaticFile> load_static(const std::string& root, std::string_view path) {
  namespace fs = std::filesystem;
  const auto not_found = [&] { return fail("http.not_found", "there is nothing at " + std::string(path)); };
  std::string relative{path.substr(1)};
  if (relative.empty() || relative.ends_with('/')) relative += "index.html";

  std::error_code error;
  const fs::path base = fs::canonical(root, error);
  if (error) return not_found();
  const fs::path file = fs::canonical(base / relative, error);
  // A link inside the root may lead out of it: the location of the link's target counts.
  const std::string prefix = base.string() == "/" ? "/" : base.string() + "/";
  if (error || !file.string().starts_with(prefix) || !fs::is_regular_file(file, error)) return not_found();

  struct stat metadata {};
  if (::stat(file.c_str(), &metadata) != 0) return not_found();
  auto bytes = read_file(file.string());
  if (!bytes) return not_found();
  const std::string etag = "\"" + std::to_string(metadata.st_size) + "-" + std::to_string(metadata.st_mtim.tv_sec) +
                           "." + std::to_string(metadata.st_mtim.tv_nsec) + "\"";
  return StaticFile{std::move(*bytes), mime_type(file.string()), etag};
}

bool etag_matches(std::string_view if_none_match, std::string_view etag) {
  return if_none_match == "*" || (!etag.empty() && if_none_match.find(etag) != std::string_view::npos);
}

}  // namespace cosiva::adapters::http_rules
