#include "cosiva/journal/replay.h"

#include "cosiva/journal/reader.h"

#include <utility>

namespace cosiva::journal {

Result<Replayed> replay(std::string_view bytes,
                        const std::function<Result<std::unique_ptr<wire::Core>>(const wire::Input&)>& make_core,
                        const std::function<void(wire::Core&)>& after) {
  auto reader = Reader::open(bytes);
  if (!reader) return tl::unexpected<Error>(reader.error());
  auto first = reader->next();
  if (!first) return tl::unexpected<Error>(first.error());
  if (!*first || (*first)->kind != wire::InputKind::configure)
    return fail("journal.configure", "a run starts with a configure record, and this journal does not", "offset 8");

  auto core = make_core(**first);
  if (!core) return tl::unexpected<Error>(core.error());
  wire::CoreRunner runner{**core};
  Replayed result;
  for (std::optional<wire::Input> input = std::move(*first); input;) {
    runner.feed(*input);
    ++result.inputs;
    auto next = reader->next();
    if (!next) return tl::unexpected<Error>(next.error());
    input = std::move(*next);
  }
  result.digest = runner.digest().hex();
  result.recorded_digest = reader->recorded_digest();
  result.truncated = reader->truncated();
  if (after) after(**core);
  return result;
}

}  // namespace cosiva::journal
