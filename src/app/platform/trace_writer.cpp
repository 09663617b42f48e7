#include "cosiva/app/platform/trace_writer.h"

#include <cerrno>
#include <cstring>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {

Result<std::unique_ptr<TraceWriter>> TraceWriter::create(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "we");
  if (file == nullptr) return fail("trace.open", std::string("cannot write: ") + std::strerror(errno), path);
  return std::unique_ptr<TraceWriter>(new TraceWriter(file));
}

TraceWriter::~TraceWriter() { std::fclose(file_); }

void TraceWriter::write(SimTime at, std::string_view from, std::string_view topic, std::string_view payload,
                        bool retained) {
  JsonWriter json;
  json.begin_object().field("time", to_iso8601(at)).field("from", from).field("topic", topic);
  json.field("retained", retained).key("payload");
  const bool one_line = payload.find('\n') == std::string_view::npos;
  if (one_line && !payload.empty() && JsonValue::parse(payload)) {
    json.raw(payload);
  } else {
    json.value(payload);
  }
  json.end_object();
  COSIVA_EXPECT(json.complete());
  std::fwrite(json.text().data(), 1, json.text().size(), file_);
  std::fputc('\n', file_);
}

}  // namespace cosiva::app
