"use strict";

// Two solvers side by side. The data are part of the page; the ratios are computed as the report computes them for the nearest references.
{
  const SVG = "http://www.w3.org/2000/svg";
  const DASH = "–";
  const data = JSON.parse(document.querySelector("script.compared").textContent);
  const { rules, marks } = data;
  const judgements = data.judged.map(([solver, where, href, counts, limits, figures]) => ({
    ...{ solver, case: where, href },
    verdicts: Object.fromEntries(counts.map(([mark, count]) => [marks[mark][1], count])),
    limits: limits.map((k) => data.limits[k]),
    balances: figures.map(([k, figure, mark]) => ({ number: k, figure, mark: marks[mark] })),
  }));
  const SIDES = ["first", "second"];
  const LETTERS = ["A", "B"];
  const WORDS = [
    ["ERROR", "error", "ERROR"],
    ["FAIL", "fail", "FAIL"],
    ["INCONCLUSIVE", "inconclusive", "INCONCLUSIVE"],
    ["PASS (known limit)", "limit", "known limit"],
    ["PASS", "pass", "PASS"],
  ];
  const role = (name) => document.querySelector(`[data-role="${name}"]`);
  const plural = (count, word, words = `${word}s`) => `${count} ${count === 1 ? word : words}`;

  // Elements: names and texts become text nodes, never markup.

  function filled(element, attributes, children) {
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    element.append(...children.filter((child) => child !== null && child !== ""));
    return element;
  }

  const make = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);
  const draw = (tag, attributes = {}, ...children) => filled(document.createElementNS(SVG, tag), attributes, children);

  function icon(kind) {
    return draw("svg", { "aria-hidden": "true" }, draw("use", { href: `#icon-${kind}` }));
  }

  const dot = ([kind, text]) => make("span", { class: `dot ${kind}`, title: text }, icon(kind), make("span", { class: "hidden" }, text));
  const verdict = ([kind, text]) => make("span", { class: `verdict ${kind} small` }, icon(kind), text);

  /** The marker of a solver as on its own page: a disc for the first, a hollow square for the second. */
  function sign(side) {
    const shape = side ? draw("rect", { x: -4, y: -4, width: 8, height: 8 }) : draw("circle", { r: 4.5 });
    return draw("svg", { class: `sign ${SIDES[side]}`, viewBox: "-6 -6 12 12", "aria-hidden": "true" }, shape);
  }

  function lanes(contents) {
    const shown = contents.map((content, side) => {
      const label = make("span", { class: "hidden" }, `${LETTERS[side]}: `);
      return make("span", { class: `lane ${SIDES[side]}` }, label, ...[content].flat());
    });
    return make("span", { class: "lanes" }, ...shown);
  }

  // Numbers, as the report writes them.

  const superscript = (power) => String(power).replace(/[-\d]/g, (sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]);

  function number(value, digits = 3) {
    if (value === null || !Number.isFinite(value)) return DASH;
    if (value === 0) return "0";
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    const power = Number(exponent);
    const text = power >= -3 && power < Math.max(digits, 4) ? Number(value.toPrecision(digits)).toFixed(Math.max(digits - 1 - power, 0)) : "";
    return (text || `${mantissa}×10${superscript(power)}`).replace(/^-/, "−");
  }

  const order = (value) => (value === null ? DASH : (Math.round(value * 100) / 100 + 0).toFixed(2).replace("-", "−"));

  function size(value) {
    const parts = 1 / value;
    if (parts > 1.5 && Math.abs(parts - Math.round(parts)) < 1e-6 * parts) return `1/${Math.round(parts)}`;
    const text = String(Number(value.toPrecision(4)));
    return text.includes("e") ? number(value, 4) : text;
  }

  // Which series belong together, and their ratios.

  const place = (trial) => [trial.series.case, trial.measure.quantity, trial.measure.norm].join("|");

  function trials(solver) {
    const mine = data.series.filter((series) => series.solver === solver);
    return mine.flatMap((series) => series.measures.map((measure) => ({ series, measure })));
  }

  function matched(first, second) {
    const pairs = [];
    for (const key of new Set(first.map(place))) {
      const [mine, theirs] = [first, second].map((trials) => trials.filter((trial) => place(trial) === key));
      const all = mine.flatMap((one) => theirs.map((other) => [one, other]));
      const alike = all.filter(([one, other]) => one.series.ladder === other.series.ladder);
      pairs.push(...(alike.length ? alike : all.filter(([one, other]) => one.series.axis === other.series.axis).slice(0, 1)));
    }
    const rank = ([one]) => data.series.indexOf(one.series);
    return pairs.sort((a, b) => rank(a) - rank(b)).map((pair) => ({ pair, ...ratios(pair) }));
  }

  function ratios(pair) {
    const nothing = { level: null, error: null, time: null, work: null };
    const [one, other] = pair;
    if (!one.series.tells || !other.series.tells || one.series.axis !== other.series.axis) return nothing;
    const largest = Math.max(...pair.flatMap(({ measure }) => measure.errors.filter((error) => error !== null)), 0);
    let level = null;
    one.series.sizes.forEach((width, k) => {
      const n = other.series.sizes.findIndex((near) => Math.abs(width - near) <= rules.sameSize * width);
      const errors = [one.measure.errors[k], n < 0 ? null : other.measure.errors[n]];
      if (errors.every((error) => error !== null && error > 0) && (!level || width < level.size)) level = { size: width, errors };
    });
    if (level && Math.max(...level.errors) <= rules.roundOff) level = null;
    const costs = (name) => pair.map(({ series, measure }) => places(series[name], measure.errors));
    const measured = largest > rules.roundOff;
    return {
      level,
      error: level && level.errors[0] / level.errors[1],
      time: measured ? atSameError(...costs("seconds"), rules.measurable) : null,
      work: measured ? atSameError(...costs("steps"), 0) : null,
    };
  }

  const places = (costs, errors) => costs.map((cost, k) => [cost, errors[k]]).filter(([cost, error]) => cost > 0 && error > 0);

  function atSameError(mine, theirs, least) {
    const both = [mine, theirs];
    if (both.some((curve) => curve.length < 2 || curve.some(([, error], k) => k > 0 && error >= curve[k - 1][1]))) return null;
    const error = Math.max(...both.map((curve) => curve.at(-1)[1]));
    if (error > Math.min(...both.map((curve) => curve[0][1]))) return null;
    const spent = both.map((curve) => costOf(curve, error));
    return Math.min(...spent) >= least ? { error, ratio: spent[0] / spent[1] } : null;
  }

  /** The cost of an error, from the logarithms of its neighbours; the errors of the curve fall. */
  function costOf(curve, error) {
    const k = curve.findIndex(([, reached]) => reached <= error);
    if (k <= 0) return curve[0][0];
    const [[x0, y0], [x1, y1]] = [curve[k - 1], curve[k]].map((pair) => pair.map(Math.log));
    return Math.exp(x0 + ((Math.log(error) - y0) / (y1 - y0)) * (x1 - x0));
  }

  function middle(values) {
    const known = values.filter((value) => value !== null && Number.isFinite(value)).sort((a, b) => a - b);
    if (!known.length) return null;
    const half = known.length / 2;
    return known.length % 2 ? known[Math.floor(half)] : Math.sqrt(known[half - 1] * known[half]);
  }

  // Pictures.

  const WIDE = 240;
  const across = (value) => 10 + ((value - rules.axis[0]) / (rules.axis[1] - rules.axis[0])) * (WIDE - 20);
  const within = (value) => Math.min(Math.max(value, rules.axis[0]), rules.axis[1]);

  function strip({ order: [measured, low, high], band, formal, accepted }) {
    const parts = [];
    const path = (kind, d) => parts.push(draw("path", { class: kind, d }));
    const ticks = [];
    for (let tick = Math.ceil(rules.axis[0]); tick <= rules.axis[1]; tick += 1) ticks.push(`M${across(tick)} 8v6`);
    path("rule", `M10 11H${WIDE - 10}${ticks.join("")}`);
    if (band) {
      const [left, right] = band.map((end) => across(within(end)));
      const width = Math.max(right - left, 1.5);
      parts.push(draw("rect", { class: "band", x: left, y: 2, width, height: 18 }));
      path("edge", `M${left} 2V20M${left + width} 2V20`);
    }
    if (formal != null && formal >= rules.axis[0] && formal <= rules.axis[1]) path("formal", `M${across(formal) - 3.5} 0h7l-3.5 5.5Z`);
    const known = low !== null && high !== null;
    if (known && low <= rules.axis[1] && high >= rules.axis[0]) {
      const [left, right] = [low, high].map((end) => across(within(end)));
      const caps = right - left > 9 ? [low, high].filter((end) => within(end) === end).map((end) => `M${across(end)} 6v10`) : [];
      path("interval", `M${left} 11H${right}${caps.join("")}`);
    }
    if (measured !== null) {
      const x = across(measured);
      const [least, most] = known ? [low, high] : [measured, measured];
      if (measured > rules.axis[1]) path("beyond", `M${WIDE - 9} 6.5l7 4.5l-7 4.5Z`);
      else if (measured < rules.axis[0]) path("beyond", "M9 6.5l-7 4.5l7 4.5Z");
      else if (band && (most < band[0] || least > band[1])) path("outside", `M${x - 4} 7l8 8m0 -8l-8 8`);
      else parts.push(draw("circle", { class: band && band[0] <= least && most <= band[1] ? "inside" : "open", cx: x, cy: 11, r: 3.4 }));
    }
    const interval = known ? `, 95 % interval [${order(low)}, ${order(high)}]` : "";
    const said = measured === null ? "no order" : `order ${order(measured)}${interval}`;
    const label = said + (accepted ? `, accepted ${accepted}` : "") + (formal != null ? `, formal ${formal}` : "");
    return draw("svg", { class: "strip", viewBox: `0 0 ${WIDE} 22`, role: "img", "aria-label": label }, ...parts);
  }

  function ruler() {
    const numbers = [];
    for (let tick = Math.ceil(rules.axis[0]); tick <= rules.axis[1]; tick += 1) {
      numbers.push(draw("text", { x: across(tick), y: 11, "text-anchor": "middle" }, String(tick)));
    }
    return draw("svg", { class: "strip ruler", viewBox: `0 0 ${WIDE} 14`, "aria-hidden": "true" }, ...numbers);
  }

  /** A bar from 1 to a ratio, in the colour of the solver whose number is smaller. */
  function bar(ratio, label) {
    const share = Math.log10(ratio) / 2;
    const x = 60 + 51 * Math.min(Math.max(share, -1), 1);
    const kind = SIDES[Number(ratio >= 1)];
    const ticks = [-2, -1, 1, 2].map((k) => `M${60 + 25.5 * k} 4v6`).join("");
    const parts = [draw("path", { class: "rule", d: `M9 7H111${ticks}` })];
    parts.push(draw("rect", { class: kind, x: Math.min(x, 60), y: 3, width: Math.abs(x - 60), height: 8 }));
    if (Math.abs(share) > 1) parts.push(draw("path", { class: kind, d: `M${x} 2l${7 * Math.sign(share)} 5l${-7 * Math.sign(share)} 5Z` }));
    parts.push(draw("path", { class: "one", d: "M60 1V13" }));
    const name = `${label} ${number(ratio, 2)}`;
    return draw("svg", { class: "ratio", viewBox: "0 0 120 14", role: "img", "aria-label": name }, ...parts);
  }

  /** Dots of all ratios on logarithmic axes, one row for each kind. */
  function dots(rows, wide) {
    const height = 56;
    const known = rows.flatMap(([, values]) => values).map((value) => Math.abs(Math.log10(value)));
    const decades = Math.min(Math.max(1, Math.ceil(Math.max(0, ...known) - 1e-9)), 6);
    const left = wide > 500 ? 110 : 16;
    const x = (value) => left + 12 + ((Math.min(Math.max(Math.log10(value) / decades, -1), 1) + 1) / 2) * (wide - left - 28);
    const base = 26 + rows.length * height;
    const parts = [];
    for (let n = -decades; n <= decades; n += 1) {
      const at = x(10 ** n);
      parts.push(draw("path", { class: n ? "grid" : "one", d: `M${at} 22V${base}` }));
      parts.push(draw("text", { x: at, y: base + 16, "text-anchor": "middle" }, n ? number(10 ** n, 1).replace("1×", "") : "1"));
    }
    parts.push(draw("text", { x: x(1) - 10, y: 13, "text-anchor": "end", class: "side" }, "A is smaller"));
    parts.push(draw("text", { x: x(1) + 10, y: 13, class: "side" }, "B is smaller"));
    rows.forEach(([name, values], k) => {
      const y = 26 + height * (k + 0.5) + (wide > 500 ? 0 : 8);
      const label = { x: wide > 500 ? left - 6 : left, y: wide > 500 ? y + 4 : y - 16, class: "name" };
      parts.push(draw("text", wide > 500 ? { ...label, "text-anchor": "end" } : label, name));
      values.forEach((value, n) => {
        const kind = SIDES[Number(value >= 1)];
        parts.push(draw("circle", { class: kind, cx: x(value), cy: y + ((n * 7) % 5 - 2) * 3, r: 4.5 }));
      });
      const half = middle(values);
      if (half !== null) {
        parts.push(draw("path", { class: "median", d: `M${x(half)} ${y - 15}v30` }));
        const near = x(half) > wide - 60;
        parts.push(draw("text", { x: x(half) + (near ? -5 : 5), y: y - 12, class: "value", "text-anchor": near ? "end" : "start" }, number(half, 2)));
      } else {
        parts.push(draw("text", { x: x(1), y: y + 4, "text-anchor": "middle" }, "not known"));
      }
    });
    const said = rows.map(([name, values]) => `${name}: median ${number(middle(values), 2)} of ${plural(values.length, "series", "series")}`);
    const label = `Ratios of A to B. ${said.join("; ")}`;
    return draw("svg", { class: "ratio-dots", viewBox: `0 0 ${wide} ${base + 24}`, role: "img", "aria-label": label }, ...parts);
  }

  // Parts of the page.

  function body(table, ...rows) {
    const old = table.tBodies.length ? [...table.tBodies] : [];
    for (const part of old) part.remove();
    table.append(...rows);
  }

  function tally(counts) {
    const items = WORDS.filter(([word]) => counts[word]).map(([word, kind, text]) => {
      const item = make("li", { class: kind }, make("span", { class: "count" }, String(counts[word])), ` ${text}`);
      item.style.flexGrow = counts[word];
      return item;
    });
    return make("ul", { class: "tally", "aria-label": "Verdicts" }, ...items);
  }

  function summed(entries) {
    const counts = {};
    for (const { verdicts } of entries) for (const [word, count] of Object.entries(verdicts)) counts[word] = (counts[word] ?? 0) + count;
    return counts;
  }

  function card(side, solver, judged) {
    const { name, page, family, mark } = data.solvers[solver];
    const link = make("a", { class: "plain", href: page }, name);
    const head = make("h2", {}, sign(side), make("span", { class: "letter" }, LETTERS[side]), " ", link);
    const said = make("p", { class: "of" }, `${family}; worst verdict of all its cases: `, verdict(mark));
    const shared = judged.length ? "Verdicts in the cases that both ran" : "No case that both ran";
    return make("div", { class: `panel ${SIDES[side]}` }, head, said, make("p", { class: "of" }, shared), tally(summed(judged)));
  }

  function heading(study, columns) {
    const link = make("a", { href: `${encodeURIComponent(study.study)}.html` }, study.title);
    return make("tr", { class: "heading" }, make("th", { scope: "rowgroup", colspan: columns }, link));
  }

  function ratioCell(label, ratio, error) {
    const title = error ? { title: `at an error of ${number(error, 2)}` } : {};
    const content = ratio === null ? [make("span", { class: "none" }, DASH)] : [make("span", { class: "value" }, number(ratio, 2)), bar(ratio, label)];
    return make("td", { class: "ratio-cell", "data-label": `${label} A ÷ B`, ...title }, ...content);
  }

  function row({ pair, level, error, time, work }, before, hrefs) {
    const [one, other] = pair;
    const names = [one.series.ladder, other.series.ladder];
    const again = before !== undefined && before.pair.every((trial, k) => trial.series === pair[k].series);
    const ladder = names[0] === names[1] ? names[0] : `A ${names[0]}; B ${names[1]}`;
    const where = data.cases[one.series.case];
    const link = make("a", { class: "plain", href: hrefs.get(one.series.case) }, where.case);
    const errors = level ? level.errors.map((value) => number(value)) : [DASH, DASH];
    const at = level ? make("span", { class: "ladder" }, `at ${one.series.axis} = ${size(level.size)}`) : null;
    const orders = pair.map(({ measure }) => [measure.mark ? dot(measure.mark) : null, ` ${order(measure.order[0])}`].filter(Boolean));
    return make(
      "tr",
      {},
      make("td", { class: again ? "where again" : "where" }, link, " ", make("span", { class: "ladder" }, ladder)),
      make("td", {}, `${one.measure.quantity} `, make("span", { class: "ladder" }, one.measure.norm)),
      make("td", { class: "strips" }, lanes(pair.map(({ measure }, k) => [sign(k), strip(measure)]))),
      make("td", { class: "number key", "data-label": "order" }, lanes(orders)),
      make("td", { class: "number", "data-label": "error" }, lanes(errors), at),
      ratioCell("Error", error),
      ratioCell("Time", time && time.ratio, time?.error),
      ratioCell("Point-steps", work && work.ratio, work?.error),
    );
  }

  function scores(found, hrefs) {
    const studies = new Map();
    for (const match of found) {
      const { study } = data.cases[match.pair[0].series.case];
      studies.set(study, [...(studies.get(study) ?? []), match]);
    }
    return [...studies.values()].map((members) => {
      const rows = members.map((match, k) => row(match, members[k - 1], hrefs));
      return make("tbody", {}, heading(data.cases[members[0].pair[0].series.case], 8), ...rows);
    });
  }

  function facts(first, second) {
    const [mine, theirs] = [first, second].map((solver) => data.solvers[solver].choices);
    const names = [...new Set([...Object.keys(mine), ...Object.keys(theirs)])];
    const rows = names
      .filter((name) => mine[name] !== theirs[name])
      .map((name) => make("tr", {}, make("td", { class: "solver" }, name), side(0, mine[name] ?? DASH), side(1, theirs[name] ?? DASH)));
    const alike = names.filter((name) => mine[name] === theirs[name]).map((name) => `${name} ${mine[name]}`);
    return { rows, alike };
  }

  const side = (k, ...children) => make("td", { "data-label": LETTERS[k], class: `side-cell ${SIDES[k]}` }, ...children);

  function balances(judged) {
    const table = new Map();
    judged.forEach((entries, k) => {
      for (const entry of entries.flatMap((one) => one.balances)) {
        if (!table.has(entry.number)) table.set(entry.number, [[], []]);
        table.get(entry.number)[k].push(entry);
      }
    });
    const shown = (members, k) => {
      if (!members.length) return side(k, make("span", { class: "none" }, "not judged"));
      const rank = ({ mark }) => WORDS.findIndex(([, kind]) => kind === mark[0]);
      const worst = members.reduce((a, b) => (rank(b) < rank(a) ? b : a));
      const figures = members.map(({ figure }) => figure).filter((figure) => figure !== null);
      const count = members.filter(({ mark }) => mark[0] === worst.mark[0]).length;
      const note = make("span", { class: "of" }, ` ${count} of ${members.length} series`);
      return side(k, make("span", { class: "value" }, figures.length ? number(Math.max(...figures)) : DASH), " ", verdict(worst.mark), note);
    };
    const rows = [...table].map(([k, sides]) => [...data.balances[k], sides]);
    return rows.sort(([a], [b]) => a - b).map(([, quantity, criterion, bound, sides]) =>
      make(
        "tr",
        {},
        make("td", { class: "solver" }, quantity),
        make("td", {}, criterion),
        make("td", { class: "number", "data-label": "Bound" }, bound),
        ...sides.map(shown),
      ),
    );
  }

  function limits(judged) {
    const table = new Map();
    judged.forEach((entries, k) => {
      for (const { case: where, href, limits: known } of entries) {
        for (const [ladder, criterion] of known) {
          if (!table.has(criterion)) table.set(criterion, [new Map(), new Map()]);
          const { study, case: name } = data.cases[where];
          table.get(criterion)[k].set(`${study}, ${name}, ${ladder}`, href);
        }
      }
    });
    const listed = (places, k) => {
      if (!places.size) return side(k, make("span", { class: "none" }, DASH));
      return side(k, make("ul", { class: "plain-list" }, ...[...places].map(([text, href]) => make("li", {}, make("a", { href }, text)))));
    };
    return [...table].map(([criterion, sides]) => make("tr", {}, make("td", {}, criterion), ...sides.map(listed)));
  }

  function verdicts(judged, shared) {
    const bodies = new Map();
    for (const where of shared) {
      const sides = judged.map((entries, k) => {
        const mine = entries.filter((entry) => entry.case === where);
        const counts = summed(mine);
        const marks = WORDS.filter(([word]) => counts[word]).map(([word, kind, text]) => make("span", { class: "counted" }, dot([kind, text]), ` ${counts[word]} ${text}`));
        return side(k, make("a", { class: "plain counts", href: mine[0].href }, ...marks));
      });
      const { study, case: name } = data.cases[where];
      if (!bodies.has(study)) bodies.set(study, make("tbody", {}, heading(data.cases[where], 3)));
      bodies.get(study).append(make("tr", {}, make("td", { class: "solver" }, name), ...sides));
    }
    return [...bodies.values()];
  }

  function alone(k, left, hrefs) {
    const rows = left.map(({ series, measure }) => {
      const { study, case: name } = data.cases[series.case];
      const link = make("a", { class: "plain", href: hrefs.get(series.case) }, `${study}, ${name}`);
      return make(
        "tr",
        {},
        make("td", {}, link, " ", make("span", { class: "ladder" }, series.ladder)),
        make("td", { "data-label": "Quantity" }, `${measure.quantity} `, make("span", { class: "ladder" }, measure.norm)),
        make("td", { class: "number", "data-label": "Order" }, order(measure.order[0])),
      );
    });
    const heads = ["Case and ladder", "Quantity and norm", "Order"].map((text, n) => make("th", { scope: "col", class: n > 1 ? "number" : "" }, text));
    const table = make("table", { class: "stacked" }, make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...rows));
    const summary = make("summary", {}, sign(k), make("span", { class: "name" }, `${LETTERS[k]} alone`), " ", make("span", { class: "of" }, `${left.length} series`));
    const region = { class: "scroll", tabindex: "0", role: "region", "aria-label": `Series of ${LETTERS[k]} alone` };
    return make("details", { class: "group" }, summary, make("div", region, table));
  }

  function sentence(found, shared) {
    if (!found.length) return shared.length ? "Both ran the same cases, but no series of theirs can be compared." : "No case was run by both: nothing can be compared.";
    const errors = found.map(({ error }) => error).filter((error) => error !== null);
    const smaller = errors.filter((error) => error < 1 / 1.01).length;
    const larger = errors.filter((error) => error > 1.01).length;
    const studies = new Set(found.map(({ pair }) => data.cases[pair[0].series.case].study)).size;
    const both = `Both ran ${plural(found.length, "series", "series")} in ${plural(studies, "study", "studies")}.`;
    if (!errors.length) return `${both} They have no level in common at which both errors are above round-off.`;
    const equal = errors.length - smaller - larger;
    const rest = equal ? `, and they agree within 1 % in ${equal}` : "";
    const times = found.map(({ time }) => time && time.ratio);
    const cost = middle(times) === null ? "" : ` At the same error, A takes ${number(middle(times), 2)} times the time of B in the median.`;
    return `${both} At the finest common level the error of A is smaller in ${smaller}, that of B in ${larger}${rest}; the median ratio is ${number(middle(errors), 2)}.${cost}`;
  }

  const narrow = matchMedia("(max-width: 600px)");
  let latest = null;

  function chart() {
    if (!latest) return;
    const values = (name) => latest.map((match) => (name === "error" ? match.error : match[name]?.ratio ?? null)).filter((value) => value !== null);
    const rows = [
      ["Error", values("error")],
      ["Time", values("time")],
      ["Point-steps", values("work")],
    ];
    role("ratios").replaceChildren(dots(rows, narrow.matches ? 350 : 760));
  }

  function show(first, second) {
    const pair = [first, second];
    const [mine, theirs] = pair.map(trials);
    const found = matched(mine, theirs);
    const all = pair.map((solver) => judgements.filter((entry) => entry.solver === solver));
    const shared = [...new Set(all[0].map((entry) => entry.case))].filter((where) => all[1].some((entry) => entry.case === where));
    const judged = all.map((entries) => entries.filter((entry) => shared.includes(entry.case)));
    const hrefs = all.map((entries) => new Map(entries.map((entry) => [entry.case, entry.href])));
    latest = found;
    role("sentence").textContent = sentence(found, shared);
    role("duel").replaceChildren(...pair.map((solver, k) => card(k, solver, judged[k])));
    chart();
    role("ratios").closest("section").hidden = !found.length;
    const table = document.querySelector("table.sides");
    table.closest("section").hidden = !found.length;
    body(table, ...scores(found, hrefs[0]));
    const { rows, alike } = facts(first, second);
    fill("choices", rows);
    role("alike").textContent = alike.length ? `The same in both: ${alike.join("; ")}.` : "";
    fill("conservation", balances(judged));
    fill("limits", limits(all));
    const section = role("verdicts");
    section.hidden = !shared.length;
    body(section.querySelector("table"), ...verdicts(judged, shared));
    const used = new Set(found.flatMap((match) => match.pair.map((trial) => `${data.series.indexOf(trial.series)}|${place(trial)}`)));
    const left = [mine, theirs].map((some) => some.filter((trial) => !used.has(`${data.series.indexOf(trial.series)}|${place(trial)}`)));
    role("alone").replaceChildren(...left.map((some, k) => (some.length ? alone(k, some, hrefs[k]) : "")).filter(Boolean));
    role("alone").closest("section").hidden = !left.some((some) => some.length);
    role("comparison").hidden = false;
  }

  function fill(name, rows) {
    const section = role(name);
    section.hidden = !rows.length;
    body(section.querySelector("table"), make("tbody", {}, ...rows));
  }

  // The choice, which the address keeps.

  const form = document.querySelector("form.pickers");
  const named = (name) => data.solvers.findIndex((solver) => solver.name === name);

  /** The solver with the most series in common with another one, of another family if there is one. */
  function partner(first) {
    const own = new Set(trials(first).map(place));
    const rank = (solver) => {
      const shared = trials(solver).filter((trial) => own.has(place(trial))).length;
      return shared + (shared && data.solvers[solver].family !== data.solvers[first].family ? 1e6 : 0);
    };
    const others = data.solvers.map((_, k) => k).filter((k) => k !== first);
    return others.reduce((a, b) => (rank(b) > rank(a) ? b : a), others[0] ?? first);
  }

  function restore() {
    const stored = new URLSearchParams(location.hash.slice(1));
    const names = ["a", "b"].map((letter) => stored.get(letter));
    const unknown = names.filter((name) => name !== null && named(name) < 0);
    const notice = role("unknown");
    notice.hidden = !unknown.length;
    notice.textContent = unknown.length ? `This report has no solver “${unknown.join("” and no “")}”.` : "";
    const first = names[0] !== null && named(names[0]) >= 0 ? named(names[0]) : 0;
    const second = names[1] !== null && named(names[1]) >= 0 ? named(names[1]) : partner(first);
    form.elements.a.value = data.solvers[first].name;
    form.elements.b.value = data.solvers[second].name;
    show(first, second);
  }

  function choose() {
    const chosen = new URLSearchParams({ a: form.elements.a.value, b: form.elements.b.value });
    history.replaceState(null, "", `#${chosen}`);
    restore();
  }

  if (data.solvers.length > 1) {
    role("ruler").append(ruler());
    form.hidden = false;
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("change", choose);
    role("swap").addEventListener("click", () => {
      [form.elements.a.value, form.elements.b.value] = [form.elements.b.value, form.elements.a.value];
      choose();
    });
    addEventListener("hashchange", () => {
      if (location.hash.includes("=")) {
        restore();
        form.scrollIntoView({ block: "center" });
      }
    });
    narrow.addEventListener("change", chart);
    restore();
  }
}
