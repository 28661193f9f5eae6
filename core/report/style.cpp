#include "core/report/style.h"

#include "core/report/plot.h"

namespace lightbatch::report {
namespace {

// Colours have names, given twice: for light and for dark. Printing uses the light ones.
constexpr const char* kLight =
    "--ink:#1b2230;--soft:#5b6577;--faint:#e3e7ee;--track:#eef1f6;--page:#f6f7fa;--card:#fff;"
    "--good:#18794e;--good-soft:#dff3e8;--bad:#b4490d;--bad-soft:#fdeadb;"
    "--c0:#2f6fdb;--c1:#d9730d;--c2:#1a8a5a;--c3:#8250df;--c4:#c2334d;";
constexpr const char* kDark =
    "--ink:#e7eaf0;--soft:#9aa4b5;--faint:#2b3342;--track:#222938;--page:#12161e;--card:#1a202b;"
    "--good:#5fd39b;--good-soft:#173528;--bad:#f5a25d;--bad-soft:#3d2816;"
    "--c0:#6ea2ff;--c1:#f2a154;--c2:#56c795;--c3:#b392f5;--c4:#f07f93;";

constexpr const char* kDrawing = R"(
.plot{max-width:100%;height:auto;display:block;font:12px system-ui,sans-serif}
.plot text{fill:var(--ink)}
.plot .tick,.plot .name{fill:var(--soft)}
.plot .marked{fill:var(--bad);font-weight:600}
.plot .grid{stroke:var(--faint)}
.plot .axis{stroke:var(--soft)}
.plot .mark{stroke:var(--bad);stroke-width:1.5;stroke-dasharray:5 4}
.plot .line{fill:none;stroke-width:2;stroke-linejoin:round}
.plot .dashed{stroke-dasharray:6 4}
.plot .bar{stroke-width:1.5}
.plot .track{fill:var(--track)}
.plot .allowed{fill:var(--good-soft)}
.plot .interval{fill:var(--c0);opacity:.45}
.plot .value{fill:var(--c0);stroke:var(--card);stroke-width:2}
.plot .dot{stroke:var(--card);stroke-width:1}
.plot .dot.c0,.plot .fill.c0{fill:var(--c0)}.plot .line.c0,.plot .bar.c0{stroke:var(--c0)}
.plot .dot.c1,.plot .fill.c1{fill:var(--c1)}.plot .line.c1,.plot .bar.c1{stroke:var(--c1)}
.plot .dot.c2,.plot .fill.c2{fill:var(--c2)}.plot .line.c2,.plot .bar.c2{stroke:var(--c2)}
.plot .dot.c3,.plot .fill.c3{fill:var(--c3)}.plot .line.c3,.plot .bar.c3{stroke:var(--c3)}
.plot .dot.c4,.plot .fill.c4{fill:var(--c4)}.plot .line.c4,.plot .bar.c4{stroke:var(--c4)}
)";

constexpr const char* kPage = R"(
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 system-ui,"Segoe UI",sans-serif}
main{max-width:1120px;margin:0 auto;padding:28px 20px 60px}
h1{font-size:1.65rem;line-height:1.25;margin:0;overflow-wrap:anywhere}
h2{font-size:1.15rem;margin:0 0 12px}
h3{font-size:.95rem;margin:20px 0 8px;color:var(--soft);font-weight:600}
p{margin:6px 0}
code{font:12.5px ui-monospace,Menlo,Consolas,monospace;overflow-wrap:anywhere}
.soft{color:var(--soft)}
.kicker{color:var(--soft);margin:0 0 4px;letter-spacing:.02em}
section,header{background:var(--card);border:1px solid var(--faint);border-radius:10px;
  padding:20px 22px;margin:0 0 18px}
.verdict{display:inline-block;font-weight:650;border-radius:999px;padding:4px 14px;margin:12px 0 4px}
.verdict.good{color:var(--good);background:var(--good-soft)}
.verdict.bad{color:var(--bad);background:var(--bad-soft)}
.verdict.plain{color:var(--soft);background:var(--track)}
.facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;margin:18px 0 0}
.fact{border-left:3px solid var(--c0);padding:2px 0 2px 12px}
.fact b{display:block;font-size:1.25rem;line-height:1.3;font-variant-numeric:tabular-nums}
.fact span{color:var(--soft);font-size:.85rem}
.columns{display:grid;grid-template-columns:repeat(auto-fit,minmax(320px,1fr));gap:8px 32px}
.beside{display:flex;flex-wrap:wrap;gap:8px 32px;margin:0 0 14px}
.beside>*{flex:1 1 380px;min-width:0}
.beside>:first-child{flex:1 1 480px}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.9rem}
th,td{text-align:left;vertical-align:top;padding:6px 14px 6px 0;border-bottom:1px solid var(--faint)}
tbody tr:last-child>*{border-bottom:0}
td:last-child,th:last-child{padding-right:0}
thead th{color:var(--soft);font-weight:600;white-space:nowrap}
tbody th{font-weight:500}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
table.pairs{max-width:680px}
table.pairs th{color:var(--soft);font-weight:400;width:42%}
table.pairs td{overflow-wrap:anywhere}
.tag{display:inline-block;border-radius:5px;padding:0 8px;font-size:.8rem;font-weight:650}
.tag.on{color:var(--good);background:var(--good-soft)}
.tag.off{color:var(--soft);background:var(--track)}
tr.off>*{color:var(--soft)}
.meter{display:block;height:6px;width:90px;border-radius:3px;background:var(--track);margin:5px 0 0 auto}
.meter i{display:block;height:100%;border-radius:3px;background:var(--c0)}
ul.plain{margin:0;padding:0;list-style:none}
.warnings{border-color:var(--bad)}
.warnings li{padding:4px 0;overflow-wrap:anywhere}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:18px;margin-top:14px}
.pictures.large{grid-template-columns:repeat(auto-fit,minmax(440px,1fr))}
figure{margin:0}
figure img{width:100%;height:auto;display:block;border-radius:6px;border:1px solid var(--faint)}
figure img.texels{image-rendering:pixelated;background:#000}
figcaption{color:var(--soft);font-size:.85rem;margin-top:6px}
footer{color:var(--soft);font-size:.85rem;overflow-wrap:anywhere}
@media (max-width:560px){.pictures.large{grid-template-columns:1fr}}
@media print{body{background:#fff;font-size:11pt}main{max-width:none;padding:0}
  section,header{border:0;border-radius:0;padding:8px 0;border-bottom:1px solid var(--faint)}
  section>h2{break-after:avoid}figure,tr,.fact{break-inside:avoid}
  *{-webkit-print-color-adjust:exact;print-color-adjust:exact}}
)";

std::string colours() {
  return std::string(":root{color-scheme:light dark;") + kLight +
         "}\n@media (prefers-color-scheme:dark){@media screen{:root{" + kDark + "}}}\n";
}

}  // namespace

std::string plot_style() { return colours() + kDrawing; }

std::string page_style() { return plot_style() + kPage; }

std::string standalone_svg(const std::string& svg) {
  const std::size_t head = svg.find('>');
  if (head == std::string::npos) return svg;
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" + svg.substr(0, head + 1) + "<style>" +
         plot_style() + "svg{background:var(--card)}</style>" + svg.substr(head + 1);
}

}  // namespace lightbatch::report
