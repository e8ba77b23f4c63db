// Pieces of the report's HTML. Nothing in it comes from elsewhere: no script, no font, no picture of others.
import { escape } from "../plot/svg.mjs";

export { escape };

export const number = (v) => v === null || v === undefined || !Number.isFinite(v) ? "–" : v === 0 ? "0"
  : Math.abs(v) >= 1e5 ? Math.round(v).toLocaleString("en") : Math.abs(v) >= 100 ? String(Math.round(v)) : Math.abs(v) >= 0.001 ? String(Number(v.toPrecision(3)))
  : v.toExponential(1).replace("e-", "e−");
export const times = (v) => v === null || v === undefined || !Number.isFinite(v) ? "–" : `${number(v)}×`;
export const bytes = (v) => v >= 1e9 ? `${number(v / 1e9)} GB` : v >= 1e6 ? `${number(v / 1e6)} MB` : v >= 1e3 ? `${number(v / 1e3)} kB` : `${v} B`;
export const count = (v) => v >= 1e6 ? `${number(v / 1e6)} M` : v >= 1e3 ? `${number(v / 1e3)} k` : String(v);

// A table that scrolls by itself where it is wider than the page. head: words; rows: cells of HTML; the first
// cell of a row is its name.
export function table(caption, head, rows, words = []) {
  if (rows.length === 0) return "";
  const cell = (c, i) => i === 0 ? `<th scope="row">${c}</th>` : `<td${words.includes(i) ? ' class="words"' : ""}>${c}</td>`;
  return `<div class="wide" role="region" tabindex="0" aria-label="${escape(caption)}"><table><caption>${escape(caption)}</caption>` +
    `<thead><tr>${head.map((h, i) => `<th scope="col"${i === 0 || words.includes(i) ? ' class="words"' : ""}>${escape(h)}</th>`).join("")}</tr></thead>\n<tbody>` +
    `${rows.map((r) => `<tr>${r.map(cell).join("")}</tr>`).join("\n")}</tbody></table></div>`;
}

export const details = (summary, inside) => inside ? `<details><summary>${escape(summary)}</summary>${inside}</details>` : "";

// A verdict in words and a sign; never in colour alone.
export const verdict = (ok, words) => ok === null ? `<span class="verdict open">${escape(words ?? "not judged")}</span>`
  : ok ? `<span class="verdict held">✓ ${escape(words ?? "holds")}</span>` : `<span class="verdict missed">✗ ${escape(words ?? "missed")}</span>`;

export const plots = (...list) => list.some(Boolean) ? `<div class="plots">${list.filter(Boolean).map((svg) => `<figure>${svg}</figure>`).join("\n")}</div>` : "";

export const STYLE = `
:root{color-scheme:light;--ink:#1a1a1a;--soft:#555;--line:#dcdcdc;--held:#00613f;--missed:#a31515}
*{box-sizing:border-box}
body{font:16px/1.55 system-ui,sans-serif;color:var(--ink);background:#fff;margin:0}
main,header,footer,nav{max-width:76rem;margin:0 auto;padding:0 1.2rem}
header{padding-top:1.6rem}h1{font-size:1.9rem;line-height:1.2;margin:0 0 .4rem}h2{font-size:1.45rem;margin:2.8rem 0 .5rem;padding-top:.6rem;border-top:2px solid var(--ink)}
h3{font-size:1.12rem;margin:1.8rem 0 .3rem}p,li{max-width:52rem}p{margin:.5rem 0}.soft{color:var(--soft)}
nav ul{display:flex;flex-wrap:wrap;gap:.2rem 1.2rem;list-style:none;padding:0;margin:.8rem 0}a{color:#00569c}
a.skip{position:absolute;left:-99rem}a.skip:focus{left:1rem;top:1rem;background:#fff;padding:.4rem}
.wide{overflow-x:auto;margin:.8rem 0}.wide:focus-visible,summary:focus-visible,a:focus-visible{outline:3px solid #00569c;outline-offset:2px}
table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums}caption{text-align:left;color:var(--soft);padding:.2rem 0}
td,th{padding:.28rem .7rem;text-align:right;border-bottom:1px solid var(--line);vertical-align:top;white-space:nowrap}
thead th{border-bottom:2px solid var(--ink);white-space:normal;vertical-align:bottom}tbody th{font-weight:500;text-align:left;white-space:normal;min-width:13rem}
.words{text-align:left;white-space:normal}th.words{text-align:left}
.verdict{font-weight:600}td .verdict{white-space:nowrap}.held{color:var(--held)}.missed{color:var(--missed)}.open{color:var(--soft);font-weight:400}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(15rem,1fr));gap:.9rem;margin:1rem 0;padding:0;list-style:none}
.cards li{border:1px solid var(--line);border-radius:.5rem;padding:.8rem 1rem}.cards b{font-size:1.7rem;line-height:1.1;display:block}
.plots{display:flex;flex-wrap:wrap;gap:1rem;margin:.6rem 0}.plots figure{margin:0;max-width:100%}svg{max-width:100%;height:auto;border:1px solid var(--line);border-radius:.3rem}
.crops{display:grid;grid-template-columns:repeat(auto-fill,minmax(8.5rem,1fr));gap:.7rem;margin:.7rem 0}.crops figure{margin:0}
.crops img+img{margin-top:3px}.crops img{image-rendering:pixelated;width:100%;height:auto;display:block;background:#888}figcaption{font-size:.82rem;color:#333;line-height:1.3;padding-top:.2rem}
.views{display:grid;grid-template-columns:repeat(auto-fill,minmax(16rem,1fr));gap:.7rem;margin:.7rem 0}.views figure{margin:0}.views img{width:100%;height:auto;display:block;background:#888}.views a+a img{margin-top:3px}
details{margin:.5rem 0}summary{cursor:pointer;color:#00569c}code{font-size:.9em;background:#f3f3f3;padding:0 .25em}footer{padding:2rem 1.2rem 3rem;color:var(--soft)}
dl{display:grid;grid-template-columns:max-content 1fr;gap:.15rem 1rem;margin:.8rem 0}dt{color:var(--soft)}dd{margin:0}
@media (max-width:40rem){dl{grid-template-columns:1fr}dd{margin-bottom:.4rem}tbody th{min-width:9rem}}`;
