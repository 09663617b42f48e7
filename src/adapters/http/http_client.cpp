#include "cosiva/adapters/http/http_client.h"

#include <curl/curl.h>

#include <initializer_list>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "cosiva/adapters/http/http_rules.h"
#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

constexpr std::size_t response_bytes_max = std::size_t{256} << 20U;
constexpr long connect_max_s = 5;

using Transfer = std::unique_ptr<CURL, decltype(&curl_easy_cleanup)>;

using HeaderLines = std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)>;

/// A line "NAME:" without a value leaves out what libcurl would send by itself.
HeaderLines header_lines(std::initializer_list<std::string> lines) {
  curl_slist* list = nullptr;
  for (const std::string& line : lines) list = curl_slist_append(list, line.c_str());
  return {list, &curl_slist_free_all};
}

/// Appends received bytes to the body; libcurl ends the transfer where fewer bytes are taken than were offered.
std::size_t receive(char* bytes, std::size_t, std::size_t count, void* body_text) {
  auto& body = *static_cast<std::string*>(body_text);
  if (body.size() + count > response_bytes_max) return 0;
  body.append(bytes, count);
  return count;
}

std::string reason(CURL* transfer, CURLcode code) {
  if (code == CURLE_WRITE_ERROR || code == CURLE_FILESIZE_EXCEEDED) return "body limit exceeded";
  long system_error = 0;
  curl_easy_getinfo(transfer, CURLINFO_OS_ERRNO, &system_error);
  if (code != CURLE_COULDNT_CONNECT || system_error == 0) return curl_easy_strerror(code);
  return std::generic_category().message(static_cast<int>(system_error));
}

tl::unexpected<Error> failure(CURL* transfer, CURLcode code, std::string url) {
  curl_off_t connected_us = 0;  // stays 0 without a connection
  curl_easy_getinfo(transfer, CURLINFO_CONNECT_TIME_T, &connected_us);
  if (connected_us > 0) return fail("http.response", "no complete response: " + reason(transfer, code), std::move(url));
  return fail("http.connect",
              "no server responds there (" + reason(transfer, code) + "); is the platform running (cosiva up)?",
              std::move(url));
}

}  // namespace

Result<HttpClient> HttpClient::make(std::string_view url) {
  constexpr std::string_view scheme = "http://";
  std::string_view authority = url.substr(url.starts_with(scheme) ? scheme.size() : url.size());
  if (authority.ends_with('/')) authority.remove_suffix(1);
  if (!http_rules::is_authority(authority))
    return fail("http.url", "expected an address such as http://127.0.0.1:8080", std::string(url.substr(0, 200)));
  HttpClient client;
  client.authority_ = authority;
  return client;
}

Result<HttpReply> HttpClient::send_request(std::string_view method, std::string_view path, const std::string& body,
                                           std::chrono::milliseconds timeout) const {
  const Transfer transfer{curl_easy_init(), &curl_easy_cleanup};
  COSIVA_EXPECT(transfer != nullptr);
  // Without "Expect" a long body is sent at once, instead of after a server's permission.
  const HeaderLines headers =
      header_lines({"Host: " + authority_, "Connection: close",
                    "Accept:", "Expect:", body.empty() ? "Content-Type:" : "Content-Type: application/json"});
  HttpReply reply;

  const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(transfer.get(), option, value); };
  set(CURLOPT_URL, url().c_str());
  set(CURLOPT_REQUEST_TARGET, std::string(path).c_str());
  set(CURLOPT_PROXY, "");  // http_proxy of the environment is for the internet
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_HTTPHEADER, headers.get());
  if (method != "GET" || !body.empty()) {
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
    set(CURLOPT_POSTFIELDS, body.c_str());
  }
  set(CURLOPT_CUSTOMREQUEST, std::string(method).c_str());
  set(CURLOPT_CONNECTTIMEOUT, connect_max_s);
  set(CURLOPT_TIMEOUT_MS, static_cast<long>(timeout.count()));
  set(CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(response_bytes_max));
  set(CURLOPT_WRITEFUNCTION, &receive);
  set(CURLOPT_WRITEDATA, &reply.body);

  const CURLcode code = curl_easy_perform(transfer.get());
  if (code != CURLE_OK) return failure(transfer.get(), code, url());
  long status = 0;
  curl_easy_getinfo(transfer.get(), CURLINFO_RESPONSE_CODE, &status);
  reply.status = static_cast<unsigned>(status);
  return reply;
}

}  // namespace cosiva::adapters
