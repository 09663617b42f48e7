#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace cosiva {

/// Executes many independent parts of one job, possibly several at a time. A core that can use more than one thread
/// uses this interface instead of own threads (docs/architecture.md); the assignment of parts to threads, and their
/// order, must not change the result.
class Workers {
 public:
  virtual ~Workers() = default;

  /// Calls part(i) once for each i < count, and returns when all have returned. `part` must not throw.
  template <typename Part>
  void for_each(std::size_t count, Part&& part) {
    using Plain = std::remove_reference_t<Part>;
    run(
        count, [](void* context, std::size_t i) { (*static_cast<Plain*>(context))(i); },
        const_cast<void*>(static_cast<const void*>(std::addressof(part))));
  }

 protected:
  using Call = void (*)(void* context, std::size_t i);
  virtual void run(std::size_t count, Call call, void* context) = 0;
};

/// Executes the parts itself, one after the other.
class AloneWorker final : public Workers {
 protected:
  void run(std::size_t count, Call call, void* context) override {
    for (std::size_t i = 0; i < count; ++i) call(context, i);
  }
};

}  // namespace cosiva
