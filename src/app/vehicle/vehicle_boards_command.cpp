#include "cosiva/app/vehicle/vehicle_boards_command.h"

#include <algorithm>
#include <cstddef>

#include "cosiva/adapters/http/http_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/vehicle/listed_vehicles.h"
#include "cosiva/base/json_text.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

constexpr std::size_t snapshot_bytes_max = std::size_t{1} << 28U;

std::string board_line(const JsonValue& board) {
  std::string text = "  " + board.text("board").value_or("?") + "  " + board.text("health").value_or("?");
  if (const auto fault = board.text("fault")) text += ", " + *fault;
  const JsonValue* parts = board.find("parts");
  if (parts == nullptr || parts->object() == nullptr) return text;
  text += "; self-test:";
  for (const auto& [part, finding] : *parts->object())
    text += " " + part + " " + (finding.text() == nullptr ? "?" : *finding.text()) + ",";
  text.pop_back();
  return text;
}

std::string pils_lines(const JsonValue& pils) {
  std::string text = "  BRAC  " + decimals(pils.number("supply").value_or(0.0), 2) + " V\n  DEMS ";
  if (const JsonValue* readings = pils.find("dems"); readings != nullptr && readings->array() != nullptr)
    for (const JsonValue& reading : *readings->array())
      text += " " + decimals(reading.number() == nullptr ? 0.0 : *reading.number(), 0);
  text += "\n  PMOT ";
  for (const char* side : {"left", "right"}) {
    const std::string name{side};
    text += " " + name + " " + decimals(pils.number(name + "Speed").value_or(0.0), 3) + " m/s " +
            decimals(pils.number(name + "Current").value_or(0.0), 3) + " A";
  }
  return text;
}

std::string proxy_line(const JsonValue& proxy) {
  return "  proxy of " + proxy.text("agent").value_or("?") + "  " + decimals(proxy.number("sent").value_or(0.0), 0) +
         " sent, " + decimals(proxy.number("delivered").value_or(0.0), 0) + " delivered";
}

std::string text_of(const JsonValue& aiv) {
  std::string text = aiv.text("id").value_or("?");
  const JsonValue* boards = aiv.find("boards");
  if (boards == nullptr || boards->array() == nullptr) return text + "\n  reports no boards";
  for (const JsonValue& board : *boards->array()) text += "\n" + board_line(board);
  if (const JsonValue* pils = aiv.find("pils")) text += "\n" + pils_lines(*pils);
  if (const auto affi = aiv.text("affi")) text += "\n  AFFI  " + *affi;
  if (const JsonValue* proxies = aiv.find("proxies"); proxies != nullptr && proxies->array() != nullptr)
    for (const JsonValue& proxy : *proxies->array()) text += "\n" + proxy_line(proxy);
  return text;
}

void write(JsonWriter& json, const JsonValue& aiv) {
  json.begin_object().field("id", aiv.text("id").value_or(""));
  for (const char* field : {"boards", "pils", "affi", "proxies"})
    if (const JsonValue* found = aiv.find(field)) write_json(json.key(field), *found);
  json.end_object();
}

}  // namespace

Result<std::string> boards_in(std::string_view snapshot_json, const std::vector<std::string>& vehicles, bool as_json) {
  const auto listed = vehicles_in(snapshot_json);
  if (!listed) return tl::unexpected(listed.error());
  std::vector<std::string> ids;
  for (const std::string& name : vehicles) {
    auto id = id_of(name, *listed);
    if (!id) return id;
    ids.push_back(std::move(*id));
  }
  const auto snapshot = JsonValue::parse(snapshot_json, snapshot_bytes_max);
  std::string text;
  JsonWriter json;
  json.begin_array();
  for (const JsonValue& aiv : *snapshot->find("aivs")->array()) {
    if (!ids.empty() && std::ranges::count(ids, aiv.text("id").value_or("")) == 0) continue;
    text += (text.empty() ? "" : "\n") + text_of(aiv);
    write(json, aiv);
  }
  json.end_array();
  return as_json ? json.take() : text.empty() ? "no vehicle" : text;
}

int run_vehicle_boards(const VehicleArguments& arguments) {
  const auto client = adapters::HttpClient::make(arguments.url);
  if (!client) return report_error(client.error());
  const auto snapshot = client->send_request("GET", "/api/v1/snapshot");
  if (!snapshot) return report_error(snapshot.error());
  const auto text = boards_in(snapshot->body, arguments.vehicles, arguments.json);
  if (!text) return report_error(text.error());
  print(*text);
  return exit_done;
}

}  // namespace cosiva::app
