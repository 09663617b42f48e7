#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/wire/messages/topics.h"

namespace cosiva::experiments {

/// Where the actual positions of vehicles come from on a running platform (A33, A34, A35): from a topic that the
/// operator names; otherwise from the GVS if one is in operation, and from the emulated plant if none is.
///
/// Invariant: the source does not change once it is in use.
class GroundTruthSource {
 public:
  enum class Kind { named, gvs, plant };

  /// @param named_topic  empty: none is named
  explicit GroundTruthSource(std::string named_topic = {});

  /// The topics of all sources that are still possible, and the GVS's connection.
  [[nodiscard]] std::vector<std::string> subscriptions() const;
  /// The GVS's connection; other messages are ignored. True: the source has changed.
  bool on_message(std::string_view topic, std::string_view payload);
  void use() { in_use_ = true; }  ///< the first run begins

  [[nodiscard]] Kind kind() const { return kind_; }
  /// The topic on which the positions are published all the time.
  [[nodiscard]] const std::string& topic() const { return topic_; }
  /// actualAIVposition: topics of requests and responses. Not for a named topic (checked).
  [[nodiscard]] std::string_view request_prefix() const;
  [[nodiscard]] std::string_view response_prefix() const;
  /// For reports: "GVS, the emulated world's camera", "the plant's ground truth", or the named topic.
  [[nodiscard]] std::string name() const;

 private:
  Kind kind_;
  std::string topic_;
  std::string camera_;  ///< the GVS's own name of its source
  bool in_use_{false};
};

}  // namespace cosiva::experiments
