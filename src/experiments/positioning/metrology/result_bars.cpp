#include "cosiva/experiments/positioning/metrology/result_bars.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"
#include "cosiva/drawing/svg/svg_writer.h"
#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

constexpr double row_px = 30.0;
constexpr double name_px = 170.0;
constexpr double gap_px = 160.0;
constexpr double width_px = 720.0;
constexpr double top_px = 8.0;
/// Beyond this ratio the smallest bar would be a stroke on the axis.
constexpr double too_far_apart = 30.0;

std::vector<double> rmse_of_runs(const Qualified& one) {
  std::vector<double> rmse;
  rmse.reserve(one.runs.size());
  for (const RunMetrics& run : one.runs) rmse.push_back(std::sqrt(run.mse_m2));
  return rmse;
}

/// Maps millimetres to the plot's horizontal axis.
class Scale {
 public:
  explicit Scale(const std::vector<const Qualified*>& ones) {
    double largest = 0.0;
    double smallest = 1e300;
    const auto take = [&](double metres) {
      if (!(metres > 0.0) || !std::isfinite(metres)) return;
      largest = std::fmax(largest, 1e3 * metres);
      smallest = std::fmin(smallest, 1e3 * metres);
    };
    for (const Qualified* one : ones) {
      for (const double rmse : rmse_of_runs(*one)) take(rmse);
      take(one->rmse_m.value);
      if (one->rmse_m.interval) take(one->rmse_m.interval->high);
      if (one->limit_m) take(*one->limit_m);
    }
    if (largest <= 0.0) largest = smallest = 1.0;
    logarithmic_ = largest > too_far_apart * smallest;
    ticks_ = logarithmic_ ? log_ticks(0.5 * smallest, largest) : experiments::ticks(0.0, largest);
  }
  [[nodiscard]] double x(double metres) const {
    const double mm = std::clamp(1e3 * metres, ticks_.front(), ticks_.back());
    const double ratio =
        logarithmic_ ? det_log(mm / ticks_.front()) / det_log(ticks_.back() / ticks_.front()) : mm / ticks_.back();
    return name_px + ratio * (width_px - name_px - gap_px);
  }
  [[nodiscard]] const std::vector<double>& ticks() const { return ticks_; }
  [[nodiscard]] bool logarithmic() const { return logarithmic_; }

 private:
  bool logarithmic_{false};
  std::vector<double> ticks_;
};

std::string gap_of(const Qualified& one) {
  if (!one.gap_percent) return {};
  const std::string sign = *one.gap_percent > 0.0 ? "+" : "";
  return sign + readable(*one.gap_percent, 1) + " %" + (one.leak ? " leak" : (one.limit_assumed ? " (assumed)" : ""));
}

void draw_row(drawing::SvgWriter& svg, const Qualified& one, const Scale& scale, double y) {
  const auto px = [&](double value) { return svg.number(value); };
  const auto at = [&](double metres) { return px(scale.x(metres)); };
  const std::string centre = px(y + 0.5 * row_px - 4.0);
  svg.shape("text").at(name_px - 8.0, y + 15.0).align(drawing::TextAlign::end).text(one.name);
  svg.shape("rect").attribute("class", "bar c0").attribute("opacity", "0.25").at(name_px, y + 2.0);
  svg.size(std::fmax(1.0, scale.x(one.rmse_m.value) - name_px), row_px - 12.0);
  if (one.rmse_m.interval) {
    svg.shape("path").attribute("class", "axis");
    svg.attribute("d", "M" + at(one.rmse_m.interval->low) + " " + px(y + row_px - 8.0) + "v4M" +
                           at(one.rmse_m.interval->low) + " " + px(y + row_px - 6.0) + "H" +
                           at(one.rmse_m.interval->high) + "m0 -2v4");
  }
  if (std::vector<double> rmse = rmse_of_runs(one); rmse.size() > 1) {
    const auto ratio = [&](double p) { return at(statistics::percentile(rmse, p)); };
    svg.shape("path").attribute("class", "line c0");
    svg.attribute("d", "M" + ratio(1e-9) + " " + centre + "H" + ratio(0.25) + "M" + ratio(0.75) + " " + centre + "H" +
                           ratio(1.0) + "M" + ratio(0.25) + " " + px(y + 4.0) + "H" + ratio(0.75) + "V" +
                           px(y + row_px - 12.0) + "H" + ratio(0.25) + "ZM" + ratio(0.5) + " " + px(y + 4.0) + "V" +
                           px(y + row_px - 12.0));
  }
  if (one.limit_m) {
    svg.shape("path").attribute("class", "line c1");
    svg.attribute("d", "M" + at(*one.limit_m) + " " + px(y - 1.0) + "V" + px(y + row_px - 7.0));
    svg.title("limit " + readable(1e3 * *one.limit_m, 2) + " mm");
  }
  svg.shape("text").at(width_px - gap_px + 12.0, y + 15.0).text(gap_of(one));
}

}  // namespace

std::string limits_beside_bars(const Qualification& all) {
  std::vector<const Qualified*> ones;
  for (const Qualified& one : all.algorithms) {
    if (!one.failed) ones.push_back(&one);
  }
  const Scale scale{ones};
  const double bottom = top_px + row_px * static_cast<double>(ones.size());
  drawing::SvgWriter svg = begin_chart(width_px, bottom + 44.0, "rmse of each");
  for (const double tick : scale.ticks()) {
    const double x = scale.x(1e-3 * tick);
    svg.shape("path").attribute("class", "grid").attribute("d", "M" + svg.number(x) + " 4V" + svg.number(bottom));
    svg.shape("text").at(x, bottom + 16.0).align(drawing::TextAlign::centre).text(readable(tick));
  }
  double y = top_px;
  for (const Qualified* one : ones) {
    draw_row(svg, *one, scale, y);
    y += row_px;
  }
  svg.shape("text").attribute("class", "label").at(name_px, bottom + 36.0);
  svg.text(std::string("rmse [mm]") + (scale.logarithmic() ? ", logarithmic" : ""));
  if (std::ranges::any_of(ones, [](const Qualified* one) { return one->gap_percent.has_value(); }))
    svg.shape("text").attribute("class", "label").at(width_px - gap_px + 12.0, bottom + 36.0).text("over the limit");
  return svg.close().take();
}

}  // namespace cosiva::experiments
