#include "cosiva/experiments/reporting/report.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

// Six colours that readers with colour vision deficiencies can distinguish as well; darker on white, lighter on black.
constexpr std::string_view style = R"(
:root{color-scheme:light dark;--ink:#1d2730;--soft:#5b6b7d;--paper:#fbfcfd;--grid:#dfe5ec;--card:#f1f4f8;--alarm:#b42318;
--c0:#2563c9;--c1:#b45f06;--c2:#0f7f6c;--c3:#a02c8c;--c4:#6b7280;--c5:#9a7b00}
@media(prefers-color-scheme:dark){:root{--ink:#e6ebf1;--soft:#9fb0c0;--paper:#12181e;--grid:#2a343e;--card:#1a222a;
--alarm:#ff8a7a;--c0:#7fb0ff;--c1:#ffb066;--c2:#4fd1b5;--c3:#e58ad2;--c4:#aab4be;--c5:#e3c64a}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:60rem;margin:2rem auto;padding:0 1rem}
h1{margin-bottom:0}h1+p{color:var(--soft);margin-top:.2rem}h2{margin-top:2.4rem}
.metadata{display:grid;grid-template-columns:repeat(auto-fit,minmax(12.5rem,1fr));gap:.8rem;margin:1.2rem 0}
.metadata div{background:var(--card);border-radius:.5rem;padding:.7rem .9rem}.metadata b{display:block;font-size:1.35rem;font-weight:600}
.metadata span{color:var(--soft);font-size:.9rem}.metadata .alarming b{color:var(--alarm)}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}th,td{padding:.3rem .6rem;text-align:right;
border-bottom:1px solid var(--grid)}th:first-child,td:first-child{text-align:left}th{color:var(--soft);font-weight:600}
.wide{overflow-x:auto}figure{margin:1.4rem 0}figcaption{color:var(--soft);font-size:.9rem}figure svg{width:100%;height:auto}
.page{break-after:page}@media print{figure,tr{break-inside:avoid}}
pre{background:var(--card);border-radius:.5rem;padding:.8rem;overflow-x:auto}
.chart text{fill:var(--soft)}.chart .label{fill:var(--ink)}.chart .grid{stroke:var(--grid);fill:none}
.chart .axis{stroke:var(--soft);fill:none}.chart .line{fill:none;stroke-width:1.8;stroke-linejoin:round}
.line.ground{stroke:var(--soft);stroke-width:8;opacity:.22}.line.c0{stroke:var(--c0)}.line.c1{stroke:var(--c1)}.line.c2{stroke:var(--c2)}.line.c3{stroke:var(--c3)}
.line.c4{stroke:var(--c4)}.line.c5{stroke:var(--c5)}.bar.c0,.point.c0{fill:var(--c0)}.bar.c1,.point.c1{fill:var(--c1)}
.bar.c2,.point.c2{fill:var(--c2)}.bar.c3,.point.c3{fill:var(--c3)}.bar.c4,.point.c4{fill:var(--c4)}
.bar.c5,.point.c5{fill:var(--c5)}
)";

std::string element(std::string_view name, std::string_view text) {
  std::string html = "<";
  html += name;
  html += '>';
  html += escaped(text);
  html += "</";
  html += name;
  html += ">\n";
  return html;
}

}  // namespace

Report::Report(std::string title, std::string subtitle) : title_{std::move(title)}, subtitle_{std::move(subtitle)} {}

Report& Report::heading(std::string_view text) {
  body_ += element("h2", text);
  return *this;
}

Report& Report::paragraph(std::string_view text) {
  body_ += element("p", text);
  return *this;
}

Report& Report::metadata(const std::vector<MetadataField>& metadata) {
  body_ += "<div class=\"metadata\">";
  for (const MetadataField& metadata_field : metadata) {
    body_ += metadata_field.alarming ? "<div class=\"alarming\"><b>" : "<div><b>";
    body_ += escaped(metadata_field.figure) + "</b><span>" + escaped(metadata_field.name) + "</span></div>";
  }
  body_ += "</div>\n";
  return *this;
}

Report& Report::table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows) {
  body_ += "<div class=\"wide\"><table><thead><tr>";
  for (const std::string& column : columns) body_ += "<th>" + escaped(column) + "</th>";
  body_ += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    COSIVA_EXPECT(row.size() == columns.size());
    body_ += "<tr>";
    for (const std::string& cell : row) body_ += "<td>" + escaped(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
  return *this;
}

Report& Report::figure(std::string_view svg, std::string_view caption) {
  body_ += "<figure>";
  body_ += svg;
  body_ += "<figcaption>" + escaped(caption) + "</figcaption></figure>\n";
  return *this;
}

Report& Report::page_break() {
  body_ += "<div class=\"page\"></div>\n";
  return *this;
}

Report& Report::verbatim(std::string_view text) {
  body_ += element("pre", text);
  return *this;
}

std::string Report::html() const {
  std::string page = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n";
  page += "<meta name=\"viewport\" content=\"width=device-width\">\n";
  page += element("title", title_);
  page += "<style>";
  page += style;
  page += "</style></head><body>\n" + element("h1", title_);
  if (!subtitle_.empty()) page += element("p", subtitle_);
  return page + body_ + "</body></html>\n";
}

}  // namespace cosiva::experiments
