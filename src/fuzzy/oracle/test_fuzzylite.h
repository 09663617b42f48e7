#pragma once

#include <fl/Headers.h>

#include <memory>
#include <span>
#include <string>

namespace cosiva::fuzzy {

/// fuzzylite's own engine, with the interface of RuleBase. The engine reads the text itself.
class Fuzzylite {
 public:
  explicit Fuzzylite(const std::string& fll) : engine_{fl::FllImporter().fromString(fll)} {
    std::string status;
    if (!engine_->isReady(&status)) engine_.reset();
  }

  [[nodiscard]] bool ready() const { return engine_ != nullptr; }

  void evaluate(std::span<const double> inputs, std::span<double> outputs) {
    for (std::size_t i = 0; i < inputs.size(); ++i) engine_->getInputVariable(i)->setValue(inputs[i]);
    engine_->process();
    for (std::size_t o = 0; o < outputs.size(); ++o) outputs[o] = engine_->getOutputVariable(o)->getValue();
  }

 private:
  std::unique_ptr<fl::Engine> engine_;
};

}  // namespace cosiva::fuzzy
