#pragma once
// The looks of a report: light and dark as the reader's system has it, on a phone, on paper.

namespace bulkley {

inline constexpr const char* report_style = R"css(
:root { color-scheme: light dark; --back: #f5f6f8; --card: #ffffff; --text: #1c2430; --soft: #5c6675; --rule: #dde1e7;
  --grid: #e8ebf0; --accent: #1f6fb2; --good: #1a7f47; --bad: #b3261e; --wait: #8a5a00;
  --c0: #1f6fb2; --c1: #d1620a; --c2: #2a8a4a; --c3: #b0307c; --c4: #6a51b8; --c5: #8c5a3c; --c6: #0f8a94; --c7: #7a7f14;
  --c8: #6b7380; }
@media (prefers-color-scheme: dark) { :root { --back: #14181e; --card: #1d232b; --text: #e4e8ee; --soft: #9ba6b5;
  --rule: #323a46; --grid: #2a313b; --accent: #6cb4f0; --good: #62c98c; --bad: #ff8a80; --wait: #f0b95a;
  --c0: #6cb4f0; --c1: #ff9f4d; --c2: #6fcf8f; --c3: #f283c0; --c4: #b5a1ff; --c5: #d3a283; --c6: #52d0da; --c7: #d3d757;
  --c8: #a9b2bf; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--back); color: var(--text);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { max-width: 1320px; margin: 0 auto; padding: 20px 16px 40px; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 32px 0 10px; }
p { margin: 4px 0; overflow-wrap: anywhere; }
.where, .note, .none, .unit, footer { color: var(--soft); }
.state { display: inline-block; padding: 1px 10px; border-radius: 10px; border: 1px solid currentColor; font-weight: 600;
  font-size: .85rem; vertical-align: middle; margin-left: 6px; }
.running { color: var(--accent); } .finished { color: var(--good); } .failed, .silent { color: var(--bad); }
.stopped, .unknown { color: var(--wait); }
.message { background: var(--card); border-left: 4px solid var(--rule); padding: 8px 12px; margin: 10px 0; }
.message.warning { border-color: var(--wait); } .message.failed, .message.silent { border-color: var(--bad); }
.message code { overflow-wrap: anywhere; }
.bar { fill: var(--c0); }
.done { height: 8px; border-radius: 4px; background: var(--rule); margin: 12px 0; overflow: hidden; }
.done div { height: 100%; background: var(--accent); }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 4px 18px; margin: 12px 0; }
dt { color: var(--soft); } dd { margin: 0; min-width: 0; overflow-wrap: anywhere; }
.plots, .pictures { display: grid; gap: 14px; grid-template-columns: repeat(auto-fill, minmax(min(380px, 100%), 1fr)); }
figure { margin: 0; padding: 10px 12px; background: var(--card); border: 1px solid var(--rule); border-radius: 8px;
  min-width: 0; }
figcaption { font-weight: 600; overflow-wrap: anywhere; }
.unit { font-weight: 400; }
.legend { font-size: .85rem; line-height: 1.4; }
.key { white-space: nowrap; margin-right: 10px; }
.key::before { content: ""; display: inline-block; width: 14px; height: 4px; border-radius: 2px; margin-right: 5px;
  vertical-align: middle; background: var(--c); }
svg { display: block; width: 100%; height: auto; margin-top: 4px; }
svg text { font-size: 11.5px; fill: var(--soft); } .up { font-size: 8.5px; }
.grid { stroke: var(--grid); } .zero { stroke: var(--soft); stroke-width: .7; } .frame { stroke: var(--soft); }
.curve { fill: none; stroke: var(--c); stroke-width: 1.6; stroke-linejoin: round; stroke-linecap: round; }
.dots { fill: none; stroke: var(--c); stroke-width: 4.5; stroke-linecap: round; }
.whisker { stroke: var(--soft); stroke-width: 1.5; }
.s0 { --c: var(--c0); } .s1 { --c: var(--c1); } .s2 { --c: var(--c2); } .s3 { --c: var(--c3); } .s4 { --c: var(--c4); }
.s5 { --c: var(--c5); } .s6 { --c: var(--c6); } .s7 { --c: var(--c7); } .s8 { --c: var(--c8); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; } th, td { text-align: left; padding: 3px 18px 3px 0; white-space: nowrap; }
th { color: var(--soft); font-weight: 400; }
img { width: 100%; height: auto; display: block; border-radius: 4px; }
pre { background: var(--card); border: 1px solid var(--rule); border-radius: 8px; padding: 10px 12px; overflow-x: auto;
  font: 13px/1.45 ui-monospace, "DejaVu Sans Mono", monospace; }
summary { cursor: pointer; color: var(--accent); }
footer { margin-top: 32px; font-size: .85rem; }
@media (max-width: 480px) { main { padding: 14px 10px 30px; } dl { grid-template-columns: 1fr; gap: 0;
  } dd { margin-bottom: 8px; }
  svg text { font-size: 13px; } .up { font-size: 9.5px; } }
@media print { :root { --back: #fff; --card: #fff; --text: #000; --soft: #444; --rule: #bbb; --grid: #ddd; --accent: #1f6fb2;
  --good: #1a7f47; --bad: #b3261e; --wait: #8a5a00; --c0: #1f6fb2; --c1: #d1620a; --c2: #2a8a4a; --c3: #b0307c;
  --c4: #6a51b8;
  --c5: #8c5a3c; --c6: #0f8a94; --c7: #7a7f14; --c8: #6b7380; }
  body { font-size: 11px; } main { max-width: none; padding: 0; } figure, .message, tr { break-inside: avoid;
  } h2 { break-after: avoid; }
  .plots, .pictures { grid-template-columns: 1fr 1fr; } pre { white-space: pre-wrap; }
  .bar, .done, .done div, .key::before { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
)css";

}  // namespace bulkley
