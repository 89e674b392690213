#pragma once

namespace kantaro::scenarios {

/// The report's style sheet. Colours are variables: one set for light and paper, one for dark.
inline constexpr char kReportStyle[] = R"css(
:root{color-scheme:light dark;--paper:#fbfaf7;--card:#ffffff;--ink:#1b2428;--soft:#5a676d;--faint:#8b979c;--rule:#e2e1db;
--pipe:#dde5e6;--shaft:#cbd6d8;--truth:#0b7285;--estimate:#d9480f;--good:#1b7a43;--good-wash:#e6f3ea;--bad:#b4232f;
--bad-wash:#fbe9e9;--pin:#3b4a9c;--wash:#f1f0eb}
@media (prefers-color-scheme:dark){:root{--paper:#14191b;--card:#1b2225;--ink:#e8ecec;--soft:#a3b0b4;--faint:#76858a;
--rule:#2e383b;--pipe:#344246;--shaft:#45565b;--truth:#4cc3d9;--estimate:#ff9757;--good:#63c98c;--good-wash:#17301f;
--bad:#ff8a8a;--bad-wash:#3a1d20;--pin:#8f9df0;--wash:#20292c}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 ui-sans-serif,system-ui,-apple-system,"Segoe UI",
Roboto,"Helvetica Neue",Arial,"DejaVu Sans",sans-serif;font-variant-numeric:tabular-nums}
main{max-width:1120px;margin:0 auto;padding:40px 28px 72px}
h1{font-size:clamp(1.7rem,1.2rem + 2vw,2.5rem);line-height:1.15;letter-spacing:-.02em;font-weight:650;margin:.15em 0 .3em;overflow-wrap:anywhere}
h2{font-size:1.2rem;letter-spacing:-.01em;font-weight:650;margin:0 0 4px}
p{margin:0}
.eyebrow{font-size:.78rem;letter-spacing:.09em;text-transform:uppercase;color:var(--soft);font-weight:600}
.lead{color:var(--soft);max-width:68ch}
.note{color:var(--soft);font-size:.9rem;max-width:76ch;margin-bottom:14px}
.verdict{margin:24px 0 0;padding:20px 24px;border-radius:14px;border-left:7px solid;display:grid;gap:4px 22px;
grid-template-columns:auto 1fr;align-items:baseline}
.verdict.passed{background:var(--good-wash);border-color:var(--good)}
.verdict.failed{background:var(--bad-wash);border-color:var(--bad)}
.verdict strong{font-size:1.7rem;line-height:1.2;letter-spacing:-.01em}
.passed strong,.ok{color:var(--good)}
.failed strong,.no{color:var(--bad)}
.verdict ul{grid-column:1/-1;margin:6px 0 0;padding-left:1.1em}
.figures{display:grid;grid-template-columns:repeat(6,1fr);gap:1px;background:var(--rule);border:1px solid var(--rule);
border-radius:14px;overflow:hidden;margin:18px 0 0}
.figures div{background:var(--card);padding:14px 16px 12px}
.figures dt{font-size:.78rem;color:var(--soft);line-height:1.3}
.figures dd{margin:3px 0 0;font-size:1.42rem;font-weight:620;letter-spacing:-.02em;line-height:1.2;white-space:nowrap}
.figures dd small{font-size:.62em;font-weight:500;color:var(--soft);letter-spacing:0;margin-left:.15em}
section{margin-top:46px;break-inside:avoid-page}
.card{background:var(--card);border:1px solid var(--rule);border-radius:14px;padding:16px}
.key{display:flex;flex-wrap:wrap;gap:4px 20px;font-size:.84rem;color:var(--soft);margin-bottom:10px}
.key span{display:inline-flex;align-items:center;gap:7px}
.key svg{width:26px;height:12px;flex:none}
svg{display:block;width:100%;height:auto;font:12px ui-sans-serif,system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",
Arial,"DejaVu Sans",sans-serif;font-variant-numeric:tabular-nums;overflow:visible}
.narrow{display:none}
.pipe{fill:none;stroke:var(--pipe);stroke-linejoin:round}
.unbuilt{fill:none;stroke:var(--faint);stroke-width:3;stroke-dasharray:3 5}
.manhole{fill:var(--shaft)}
.terminal{stroke:var(--ink);stroke-width:1.6}
.joint{stroke:var(--faint);stroke-width:1;opacity:.65}
.inlet{stroke:var(--pipe)}
.fault{fill:var(--bad);stroke:var(--card);stroke-width:1.5}
.truth{fill:none;stroke:var(--truth);stroke-width:3;stroke-linejoin:round;stroke-linecap:round}
.plan .truth{stroke-width:7;opacity:.5}
.plan .estimate{stroke-width:2.2;stroke-dasharray:7 4}
.estimate{fill:none;stroke:var(--estimate);stroke-width:1.8;stroke-dasharray:6 4;stroke-linejoin:round}
.time .truth{stroke-width:2.2}
.error{fill:none;stroke:var(--estimate);stroke-width:1.8}
.dot{fill:var(--card);stroke:var(--truth);stroke-width:2.5}
.dot.end{fill:var(--truth);stroke:var(--card);stroke-width:2}
.pin{fill:var(--pin);stroke:var(--card);stroke-width:1.5}
.pin-number{fill:var(--card);font-size:10px;font-weight:700}
.mark{stroke:var(--pin);stroke-width:1;opacity:.28}
.name{fill:var(--ink);font-size:13px;font-weight:600}
.small,.tick{fill:var(--soft);font-size:11.5px}
.scale{fill:none;stroke:var(--soft);stroke-width:1.4}
.panel-title{fill:var(--ink);font-size:12.5px;font-weight:600}
.axis{stroke:var(--faint);stroke-width:1}
.grid{stroke:var(--rule);stroke-width:1;fill:none}
.limit{stroke:var(--bad);stroke-width:1.2;stroke-dasharray:3 3;fill:none}
.limit-label{fill:var(--bad);font-size:11px}
.phase{fill:var(--wash)}
.phase.turning{fill:var(--truth)}
.phase-name{fill:var(--soft);font-size:11px}
.phase-name.on{fill:var(--card)}
.window{fill:var(--wash)}
.hit{fill:var(--truth)}
.no-return{fill:var(--faint);opacity:.55}
.clock{display:inline-block;width:22px;height:22px;vertical-align:-6px;margin-right:7px}
.clock circle{fill:none;stroke:var(--faint);stroke-width:1.4}
.clock .at{fill:var(--bad);stroke:none}
.strip{display:grid;grid-template-columns:repeat(auto-fill,minmax(228px,1fr));gap:16px}
figure{margin:0;break-inside:avoid}
figure img{display:block;width:100%;height:auto;border-radius:10px;background:#000}
figcaption{font-size:.86rem;line-height:1.4;margin-top:7px;display:flex;gap:8px}
figcaption b{flex:none;width:20px;height:20px;border-radius:50%;background:var(--pin);color:var(--card);font-size:.7rem;
line-height:20px;text-align:center;margin-top:1px}
figcaption i{font-style:normal;color:var(--soft)}
.laser-row{display:grid;grid-template-columns:minmax(240px,380px) 1fr;gap:28px;align-items:center}
table{width:100%;border-collapse:collapse;font-size:.92rem}
th{text-align:left;font-size:.78rem;color:var(--soft);font-weight:600;padding:0 14px 8px 0;border-bottom:1px solid var(--rule);vertical-align:bottom}
td{padding:10px 14px 10px 0;border-bottom:1px solid var(--rule);vertical-align:middle}
tr{break-inside:avoid}
th:last-child,td:last-child{padding-right:0}
.number{text-align:right;white-space:nowrap}
.mark-cell{width:1.9em;font-weight:700;font-size:1.05rem}
.thumb{width:92px}
.thumb img{display:block;width:84px;height:84px;object-fit:cover;border-radius:8px;background:#000}
.tag{display:inline-block;font-size:.8rem;font-weight:600;padding:1px 9px;border-radius:99px;white-space:nowrap}
.tag.ok{background:var(--good-wash)}
.tag.no{background:var(--bad-wash)}
.two{display:grid;grid-template-columns:1fr 1fr;gap:0 48px}
.facts{margin:10px 0 0;display:grid;grid-template-columns:auto 1fr;font-size:.92rem}
.facts dt,.facts dd{margin:0;padding:7px 0;border-bottom:1px solid var(--rule)}
.facts dt{color:var(--soft);padding-right:20px}
.facts dd{text-align:right}
.hash{font:.78rem/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,"DejaVu Sans Mono",monospace;color:var(--soft);
overflow-wrap:anywhere;margin-top:14px}
details{margin-top:14px;font-size:.92rem}
summary{cursor:pointer;color:var(--soft)}
details table{margin-top:10px}
@media (max-width:820px){.figures{grid-template-columns:repeat(3,1fr)}.two{grid-template-columns:1fr;gap:34px}}
@media screen and (max-width:640px){main{padding:24px 16px 56px}.wide{display:none}.narrow{display:block}
.verdict{grid-template-columns:1fr;padding:16px 18px}.figures{grid-template-columns:1fr 1fr}section{margin-top:38px}
.card{padding:12px 10px}.strip{grid-template-columns:1fr 1fr;gap:14px 10px}.laser-row{grid-template-columns:1fr;gap:14px}
.checks thead,.faults thead{display:none}
.checks tr{display:grid;grid-template-columns:1.9em max-content 1fr;gap:0 14px;padding:11px 0;border-bottom:1px solid var(--rule)}
.checks td{border:0;padding:0;text-align:left;grid-column:2/-1}.checks .mark-cell{grid-column:1;grid-row:1/3}
.checks .number:nth-of-type(3){grid-column:2}.checks .number:nth-of-type(4){grid-column:3}
.checks .number{font-size:.85rem;color:var(--soft);white-space:normal}.checks .number[data-label]::before{content:attr(data-label) " "}
.faults tr{display:grid;grid-template-columns:98px max-content 1fr;gap:0 12px;padding:11px 0;border-bottom:1px solid var(--rule)}
.faults td{border:0;padding:0;grid-column:2/-1;text-align:left}.faults .thumb{grid-column:1;grid-row:1/5}
.faults .number:nth-of-type(4){grid-column:2}.faults .number:nth-of-type(5){grid-column:3}
.faults .number{font-size:.86rem;color:var(--soft)}.faults .number[data-label]::before{content:attr(data-label) " "}}
@media print{@page{size:A4;margin:14mm 13mm}:root{color-scheme:light;--paper:#fff;--card:#fff;--ink:#111a1d;--soft:#4c585d;
--faint:#8b979c;--rule:#d7d9d6;--pipe:#dde5e6;--shaft:#cbd6d8;--truth:#0b7285;--estimate:#d9480f;--good:#1b7a43;
--good-wash:#e6f3ea;--bad:#b4232f;--bad-wash:#fbe9e9;--pin:#3b4a9c;--wash:#f1f0eb}
*{-webkit-print-color-adjust:exact;print-color-adjust:exact}body{font-size:10.5pt}main{max-width:none;padding:0}
section{margin-top:9mm}.figures{grid-template-columns:repeat(6,1fr)}.figures dd{font-size:1.15rem}
.two{grid-template-columns:1fr 1fr;gap:0 10mm}.strip{grid-template-columns:repeat(4,1fr);gap:3mm}.card{padding:3mm}
h2{break-after:avoid}.tick,.small,.phase-name,.limit-label{font-size:15px}.name,.panel-title{font-size:16.5px}.laser text{font-size:12px}.strip-section,.table-section{break-inside:auto}details:not([open]){display:none}}
)css";

}  // namespace kantaro::scenarios
