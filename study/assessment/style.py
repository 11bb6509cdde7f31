"""Style of the pages of assessments, from a phone to paper."""

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #111; background: #fff; max-width: 68rem; margin: auto;
  padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.2; }
h2 { font-size: 1.2rem; margin-top: 2rem; }
details { margin-top: .5rem; }
.answer { border-left: .4rem solid #0072b2; padding: .3rem 1rem; background: #f2f7fb; }
.answer td.text { min-width: 9rem; }
.answer td:first-child { white-space: nowrap; }
.answer th { white-space: normal; vertical-align: bottom; }
@media screen and (min-width: 1100px) { .answer td.text { white-space: nowrap; } }
.tight, .pair table { font-size: .85rem; }
.tight th, .tight td { padding: .2rem .4rem; }
th.group { text-align: center; }
.group { border-left: 1px solid #ccc; }
.tight td:nth-child(2) { text-align: left; color: #555; }
.answer th, .answer td { border-bottom: 0; }
summary { cursor: pointer; color: #333; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem; text-align: right; border-bottom: 1px solid #ccc; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
th.text, td.text { text-align: left; }
td.text { white-space: normal; min-width: 14rem; }
.pair { display: grid; gap: 0 1.5rem; align-items: start;
  grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); }
figure { margin: 1rem 0; min-width: 0; }
figure svg { width: 100%; max-width: 40rem; height: auto; }
figure .wide { min-width: 36rem; max-width: none; }
figcaption { color: #444; font-size: .9rem; }
pre { max-width: 88ch; white-space: pre-wrap; overflow-wrap: anywhere; background: #f5f5f5; padding: .7rem; }
dl { display: grid; grid-template-columns: auto 1fr; gap: .2rem 1rem; }
dt { font-weight: 600; }
dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 600px) {
  body { font-size: 15px; padding: .7rem; }
  dl { grid-template-columns: 1fr; }
  dd { margin-bottom: .5rem; }
}
@page { size: A4; margin: 14mm; }
@media print {
  :root { font-size: 12.5px; }
  body { max-width: none; font-size: 9pt; padding: 0; }
  details { display: none; }
  figure, tr, dl, pre { break-inside: avoid; }
  h2 { break-after: avoid; }
  .pair { grid-template-columns: 1fr 1fr; }
  figure svg { max-width: 38rem; }
  .scroll { overflow: visible; }
  th, td, td.text, .answer td.text { white-space: normal; min-width: 0; padding: .25rem .3rem; }
  .tight { break-inside: avoid; }
  .tight th, .tight td { white-space: nowrap; padding: .2rem .25rem; }
  figure .wide { min-width: 0; }
}
"""
