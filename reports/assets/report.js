"use strict";

// Charts are drawn when they scroll into view. Their data are part of the page: neither a network nor a server is needed.

const CONFIG = { displaylogo: false, responsive: true, displayModeBar: false };
let library = null;

function plotly() {
  library ??= new Promise((resolve, reject) => {
    if (window.Plotly) {
      resolve(window.Plotly);
      return;
    }
    const script = document.createElement("script");
    script.src = "assets/plotly.min.js";
    script.onload = () => resolve(window.Plotly);
    script.onerror = () => reject(new Error("assets/plotly.min.js is missing: run `mpmverify report` again"));
    document.head.append(script);
  });
  return library;
}

/** Returns a copy of a figure with every "var(--name)" replaced by its current value in the style sheet. */
function themed(value) {
  const sheet = getComputedStyle(document.documentElement);
  const walk = (part) => {
    if (typeof part === "string") {
      return part.startsWith("var(--") ? sheet.getPropertyValue(part.slice(4, -1)).trim() : part;
    }
    if (Array.isArray(part)) return part.map(walk);
    if (part === null || typeof part !== "object" || ArrayBuffer.isView(part)) return part;
    return Object.fromEntries(Object.entries(part).map(([name, entry]) => [name, walk(entry)]));
  };
  return walk(value);
}

/** Decodes rows of numbers from 16-bit integers in base64; null stands for a non-finite value. */
function unpacked(field, columns) {
  const bytes = Uint8Array.from(atob(field.data), (letter) => letter.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  const rows = [];
  for (let at = 0; at < bytes.length; at += 2 * columns) {
    const row = new Array(columns);
    for (let k = 0; k < columns; k += 1) {
      const step = view.getInt16(at + 2 * k, true);
      row[k] = step === -32768 ? null : field.low + (step + 32767) * field.scale;
    }
    rows.push(row);
  }
  return rows;
}

const minus = (value) => Number(value.toPrecision(4)).toString().replace("-", "−");

class Case {
  constructor(section) {
    this.section = section;
    this.figures = JSON.parse(section.querySelector("script.figures").textContent);
    this.drawn = new Map();
    this.fields = new Map();
    this.timer = null;
    this.series = this.firstSeries();
    this.prepare();
  }

  role(name) {
    return this.section.querySelector(`[data-role="${name}"]`);
  }

  on(element, event, handler) {
    element?.addEventListener(event, handler.bind(this));
  }

  firstSeries() {
    if (!this.role("time")) return Number(this.role("series")?.value ?? 0);
    const shown = [...this.section.querySelectorAll("input[data-series]:checked")].map((box) => Number(box.dataset.series));
    const kept = this.figures.series.findIndex((entry) => entry.waves);
    return shown.find((k) => this.figures.series[k].waves) ?? Math.max(kept, 0);
  }

  prepare() {
    this.on(this.role("view"), "change", () => this.refresh("convergence"));
    for (const button of this.section.querySelectorAll("[data-download]")) {
      this.on(button, "click", () => this.download(button.dataset.download));
    }
    for (const name of ["quantity", "norm"]) this.on(this.role(name), "change", this.chooseMeasure);
    for (const box of this.section.querySelectorAll("input[data-series]")) this.on(box, "change", () => this.refreshSeries());
    for (const button of this.section.querySelectorAll("[data-pick]")) this.on(button, "click", () => this.pick(button.dataset.pick));
    for (const button of this.section.querySelectorAll("[data-focus]")) {
      this.on(button, "click", () => this.chooseSeries(Number(button.dataset.focus)));
    }
    this.on(this.role("series"), "change", (event) => this.chooseSeries(Number(event.target.value)));
    this.on(this.role("wave-quantity"), "change", () => this.refreshWaves());
    this.on(this.role("time"), "input", () => this.refresh("profile"));
    this.on(this.role("play"), "click", this.togglePlay);
    if (this.role("quantity")) this.relabel();
    if (this.role("series")) this.chooseSeries(this.series);
    for (const chart of this.section.querySelectorAll(".chart")) watch(chart, () => this.draw(chart));
  }

  // Convergence

  get measure() {
    return `${this.role("quantity").value}|${this.role("norm").value}`;
  }

  /** Writes the orders in the chosen measure into the legend, and dims the series that do not have this measure. */
  relabel() {
    const orders = new Map();
    for (const { meta } of this.figures.convergence.data) if (meta.measure === this.measure) orders.set(meta.series, meta.order);
    for (const box of this.section.querySelectorAll("input[data-series]")) {
      const label = box.closest("label");
      const order = orders.get(Number(box.dataset.series));
      label.classList.toggle("absent", order === undefined);
      label.querySelector(".order").textContent = order ?? "";
    }
  }

  chooseMeasure() {
    this.relabel();
    for (const table of this.section.querySelectorAll("[data-measure]")) table.hidden = table.dataset.measure !== this.measure;
    this.refresh("convergence");
  }

  pick(which) {
    for (const box of this.section.querySelectorAll("input[data-series]")) {
      box.checked = which === "all" || (which !== "none" && box.dataset[which] === "1");
    }
    this.refreshSeries();
  }

  chosen() {
    const boxes = [...this.section.querySelectorAll("input[data-series]:checked")];
    return new Set(boxes.map((box) => Number(box.dataset.series)));
  }

  convergence() {
    const { data, layout, titles } = this.figures.convergence;
    const chosen = this.chosen();
    const mine = data.filter((trace) => trace.meta.measure === this.measure);
    const shown = mine.filter(({ meta }) => (meta.members ? meta.members.some((k) => chosen.has(k)) : chosen.has(meta.series)));
    const view = this.role("view").value;
    const errors = shown.flatMap(({ y }) => y).filter((value) => value > 0);
    // Ticks at powers of ten alone would leave an axis of less than a decade without numbers.
    const dtick = Math.max(...errors) > 30 * Math.min(...errors) ? layout.yaxis.dtick : undefined;
    const yaxis = { ...layout.yaxis, dtick, title: { text: titles[this.measure], standoff: 8 } };
    if (view === "local") return this.localOrders(shown, layout);
    if (view !== "size") return this.costs(shown, { ...layout, yaxis }, view);
    return { data: shown, layout: { ...layout, yaxis } };
  }

  /** Returns the chart of the order from each level to the next finer one, with the accepted bands behind it. */
  localOrders(traces, layout) {
    const axes = traces.filter(({ meta }) => meta.local).map((trace) => ({ ...trace, y: trace.meta.local }));
    const bands = new Map(traces.filter(({ meta }) => meta.accepted).map(({ meta }) => [String(meta.accepted), meta.accepted]));
    const seen = [...axes.flatMap(({ y }) => y), ...[...bands.values()].flat()].filter((value) => value !== null);
    const low = Math.max(-1, Math.min(...seen) - 0.3);
    const high = Math.min(6, Math.max(...seen) + 0.3);
    const shapes = [...bands.values()].map(([y0, y1]) => ({
      ...{ type: "rect", layer: "below", xref: "paper", x0: 0, x1: 1, y0, y1: y1 ?? high, fillcolor: "var(--band)" },
      line: { width: y0 === y1 ? 1 : 0, dash: "dash", color: "var(--muted)" },
    }));
    const yaxis = { ...layout.yaxis, type: "linear", dtick: undefined, range: [low, high] };
    return { data: axes, layout: { ...layout, shapes, yaxis: { ...yaxis, title: { text: "order from the coarser level", standoff: 8 } } } };
  }

  /** Returns the chart of error against cost, with the front of the runs that no other shown run beats in both. */
  costs(traces, layout, cost) {
    const drawn = traces
      .filter(({ meta }) => meta.local)
      .map((trace) => ({ ...trace, x: this.figures.series[trace.meta.series][cost], xaxis: "x" }));
    const points = drawn.flatMap(({ x, y }) => x.map((value, k) => [value, y[k]]));
    const usable = points.filter(([value, error]) => value > 0 && error > 0).sort(([a, e], [b, f]) => a - b || e - f);
    const front = [];
    for (const point of usable) if (!front.length || point[1] < front.at(-1)[1]) front.push(point);
    const line = { color: "var(--muted)", width: 6 };
    const pareto = {
      ...{ type: "scatter", mode: "lines", hoverinfo: "skip", opacity: 0.3, line, meta: {} },
      ...{ x: front.map(([value]) => value), y: front.map(([, error]) => error) },
    };
    const title = cost === "seconds" ? "wall time [s]" : "point-steps";
    const { gridcolor, zerolinecolor, linecolor, exponentformat, automargin } = layout.xaxis;
    const plain = { gridcolor, zerolinecolor, linecolor, exponentformat, automargin };
    const { yaxis, ...rest } = Object.fromEntries(Object.entries(layout).filter(([name]) => !/^xaxis/.test(name)));
    return { data: [pareto, ...drawn], layout: { ...rest, yaxis, xaxis: { ...plain, type: "log", title: { text: title, standoff: 8 } } } };
  }

  async download(format) {
    const chart = this.section.querySelector('[data-chart="convergence"]');
    const name = `${this.section.id}-${this.measure.replace("|", "-")}`;
    if (format !== "csv") {
      const Plotly = await plotly();
      await Plotly.downloadImage(chart, { format, filename: name, width: 900, height: 600, scale: format === "png" ? 2 : 1 });
      return;
    }
    const quoted = (text) => `"${String(text).replaceAll('"', '""')}"`;
    const chosen = this.chosen();
    const rows = this.figures.convergence.data
      .filter(({ meta }) => meta.measure === this.measure && chosen.has(meta.series))
      .flatMap(({ name: series, x, y, meta }) => {
        const { seconds, steps } = this.figures.series[meta.series];
        return x.map((size, k) => [quoted(series), size, y[k], meta.local[k], seconds[k], steps[k]].map((cell) => cell ?? "").join(","));
      });
    const text = ["series,size,error,order_from_coarser,wall_seconds,point_steps", ...rows].join("\n");
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([`${text}\n`], { type: "text/csv" }));
    link.download = `${name}.csv`;
    link.click();
    URL.revokeObjectURL(link.href);
  }

  theory() {
    const { data, layout } = this.figures.theory;
    return { data: data.filter(({ meta }) => this.chosen().has(meta.series)), layout };
  }

  // Waves of one series

  chooseSeries(k) {
    this.series = k;
    this.role("series").value = String(k);
    for (const button of this.section.querySelectorAll("[data-focus]")) {
      button.setAttribute("aria-pressed", String(Number(button.dataset.focus) === k));
    }
    const { waves, h, histories } = this.figures.series[k];
    const slider = this.role("time");  // only where a wave is drawn
    if (slider) {
      const share = Number(slider.value) / Number(slider.max);
      slider.max = String(waves ? waves.t.length - 1 : 1);
      slider.value = String(Math.round(share * Number(slider.max)));
      this.role("level").textContent = h ? ` (level h = ${h} m)` : "";
    }
    const place = this.role("histories");
    for (const chart of place.querySelectorAll(".chart")) this.forget(chart);
    place.replaceChildren(...histories.map((figure, index) => this.multiple(figure, index)));
    if (slider) this.refreshWaves();
  }

  multiple(figure, index) {
    const box = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const chart = document.createElement("div");
    caption.textContent = figure.title;
    chart.className = "chart small";
    chart.dataset.chart = `history-${index}`;
    chart.setAttribute("role", "img");
    chart.setAttribute("aria-label", `${figure.title} over time`);
    box.append(caption, chart);
    watch(chart, () => this.draw(chart));
    return box;
  }

  /** Returns the fields of the chosen series and quantity, decoded once; null if there are none. */
  field() {
    const quantity = this.role("wave-quantity").value;
    const { waves } = this.figures.series[this.series];
    if (!waves || !waves.fields[quantity]) return null;
    const key = `${this.series} ${quantity}`;
    if (!this.fields.has(key)) {
      const { value, error, signed } = waves.fields[quantity];
      const columns = waves.x.length;
      this.fields.set(key, { x: waves.x, t: waves.t, signed, value: unpacked(value, columns), error: unpacked(error, columns) });
    }
    return this.fields.get(key);
  }

  profile() {
    const field = this.field();
    const figure = this.figures.waves[this.role("wave-quantity").value].profile;
    if (!field) return { data: [], layout: figure.layout };
    const k = Math.min(Number(this.role("time").value), field.t.length - 1);
    this.role("clock").textContent = `t = ${minus(field.t[k])} s`;
    const { paint, symbol } = this.figures.series[this.series];
    const exact = field.value[k].map((value, p) => (value === null || field.error[k][p] === null ? null : value - field.error[k][p]));
    const rows = [exact, field.value[k], field.error[k]];
    const data = figure.data.map((trace, n) => ({
      ...trace,
      x: field.x,
      y: rows[n],
      line: { color: paint, ...trace.line },
      ...(trace.marker ? { marker: { ...trace.marker, color: paint, symbol } } : {}),
    }));
    const yaxis = { ...figure.layout.yaxis, range: this.range(field, "value") };
    const yaxis2 = { ...figure.layout.yaxis2, range: this.range(field, "error") };
    return { data, layout: { ...figure.layout, yaxis, yaxis2 } };
  }

  /** Returns the range over all times, so that the axis stays fixed while the wave moves. */
  range(field, name) {
    const values = field[name].flat().filter((value) => value !== null);
    if (!values.length) return undefined;
    const low = values.reduce((a, b) => Math.min(a, b));
    const high = values.reduce((a, b) => Math.max(a, b));
    const room = Math.max(0.06 * (high - low), 1e-6 * Math.max(Math.abs(low), Math.abs(high))) || 1e-16;
    return [low - room, high + room];
  }

  heat(name) {
    const field = this.field();
    const figure = this.figures.waves[this.role("wave-quantity").value][name];
    if (!field) return { data: [], layout: figure.layout };
    const [trace] = figure.data;
    const scale = name === "value" && field.signed ? { colorscale: figure.signed, zmid: 0 } : {};
    return { data: [{ ...trace, ...scale, x: field.x, y: field.t, z: field[name] }], layout: figure.layout };
  }

  history(index) {
    const { time, histories } = this.figures.series[this.series];
    const { data, axis } = histories[index];
    const { history } = this.figures;
    const yaxis = { ...history.yaxis, title: { text: axis, standoff: 8 } };
    return { data: data.map((trace) => ({ x: time, ...trace })), layout: { ...history, yaxis, showlegend: data.length > 1 } };
  }

  togglePlay() {
    const button = this.role("play");
    const slider = this.role("time");
    const playing = this.timer === null;
    button.setAttribute("aria-pressed", String(playing));
    button.textContent = playing ? "Pause" : "Play";
    if (!playing) {
      clearInterval(this.timer);
      this.timer = null;
      return;
    }
    if (slider.value === slider.max) slider.value = "0";
    this.timer = setInterval(() => {
      slider.value = String(Number(slider.value) + 1);
      this.refresh("profile");
      if (slider.value === slider.max) this.togglePlay();
    }, 110);
  }

  // Drawing

  figure(kind) {
    if (kind === "convergence") return this.convergence();
    if (kind === "theory") return this.theory();
    if (kind === "profile") return this.profile();
    if (kind.startsWith("dominance-")) return this.figures.dominance[Number(kind.slice(10))];
    if (kind.startsWith("history-")) return this.history(Number(kind.slice(8)));
    return this.heat(kind);
  }

  async draw(chart) {
    const Plotly = await plotly();
    if (!chart.isConnected) return;
    const { data, layout } = themed(this.figure(chart.dataset.chart));
    if (!this.drawn.has(chart)) chart.replaceChildren(); // the still picture in its place
    this.drawn.set(chart, Plotly);
    Plotly.react(chart, data, layout, CONFIG);
  }

  forget(chart) {
    this.drawn.get(chart)?.purge(chart);
    this.drawn.delete(chart);
  }

  refresh(kind) {
    for (const chart of [...this.drawn.keys()]) if (chart.dataset.chart === kind) this.draw(chart);
  }

  refreshSeries() {
    for (const kind of ["convergence", "theory"]) this.refresh(kind);
  }

  refreshWaves() {
    for (const kind of ["profile", "value", "error"]) this.refresh(kind);
  }

  redraw() {
    for (const chart of [...this.drawn.keys()]) this.draw(chart);
  }
}

const waiting = new Map();
const observer = new IntersectionObserver(
  (entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      observer.unobserve(entry.target);
      waiting.get(entry.target)?.();
      waiting.delete(entry.target);
    }
  },
  { rootMargin: "300px" },
);

function watch(element, action) {
  waiting.set(element, action);
  observer.observe(element);
}

/** Opens the folded parts around what the address points to, and a folded case itself. */
function unfold() {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  const own = target.matches("section.case") ? target.querySelector("details") : null;
  for (let folded = own ?? target.closest("details"); folded; folded = folded.parentElement.closest("details")) folded.open = true;
  target.scrollIntoView();
}

/** Marks the case that is read in the table of contents. */
function follow() {
  const shown = document.querySelectorAll('.outline a, .contents a[href^="#"]');
  const links = new Map([...shown].map((link) => [decodeURIComponent(link.hash.slice(1)), link]));
  const seen = new Set();
  const spy = new IntersectionObserver(
    (entries) => {
      for (const { isIntersecting, target } of entries) seen[isIntersecting ? "add" : "delete"](target.id);
      const [first] = [...links.keys()].filter((id) => seen.has(id));
      for (const [id, link] of links) {
        if (id === first) link.setAttribute("aria-current", "true");
        else link.removeAttribute("aria-current");
      }
      links.get(first)?.scrollIntoView({ block: "nearest" });
    },
    { rootMargin: "-15% 0px -75% 0px" },
  );
  for (const section of document.querySelectorAll("section.case, .prose > section")) spy.observe(section);
}

/** Filters and sorts the cards of the overview; the choices are kept in the address, so that a link shows the same cards. */
function filter(form) {
  const list = document.querySelector(".cards");
  const cards = [...list.children];
  const worst = ["ERROR", "FAIL", "INCONCLUSIVE", "PASS"];
  const by = {
    verdict: (a, b) => worst.indexOf(a.dataset.verdict) - worst.indexOf(b.dataset.verdict),
    seconds: (a, b) => b.dataset.seconds - a.dataset.seconds,
    name: (a, b) => a.dataset.name.localeCompare(b.dataset.name),
  };
  const show = () => {
    const { find, verdict, dimension, family, sort } = Object.fromEntries(new FormData(form));
    const words = find.toLowerCase().split(/\s+/);
    const has = (value, among) => !value || among.split("|").includes(value);
    for (const card of cards) {
      const { dataset } = card;
      const found = words.every((word) => dataset.words.includes(word));
      card.hidden = !(found && has(verdict, dataset.verdict) && has(dimension, dataset.dimension) && has(family, dataset.family));
    }
    list.append(...(sort ? cards.toSorted(by[sort]) : cards));
    const shown = cards.filter((card) => !card.hidden).length;
    form.querySelector("output").textContent = shown < cards.length ? `${shown} of ${cards.length} studies` : `${shown} studies`;
  };
  const restore = () => {
    const stored = new URLSearchParams(location.hash.includes("=") ? location.hash.slice(1) : "");
    for (const field of form.elements) if (field.name) field.value = stored.get(field.name) ?? "";
    for (const field of form.querySelectorAll("select")) if (field.selectedIndex < 0) field.value = "";
    show();
  };
  const keep = () => {
    const chosen = new URLSearchParams([...new FormData(form)].filter(([, value]) => value));
    history.replaceState(null, "", `#${chosen}`);
    show();
  };
  form.addEventListener("input", keep);
  form.addEventListener("submit", (event) => event.preventDefault());
  addEventListener("hashchange", restore);
  form.hidden = false;
  restore();
}

const filters = document.querySelector("form.filters");
if (filters) filter(filters);

const cases = new Map();
const near = new IntersectionObserver(
  (entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting || cases.has(target)) continue;
      cases.set(target, new Case(target));
      near.unobserve(target);
    }
  },
  { rootMargin: "600px" },
);
for (const section of document.querySelectorAll("section.case")) near.observe(section);

const redraw = () => cases.forEach((entry) => entry.redraw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
addEventListener("beforeprint", () => {
  document.documentElement.dataset.theme = "light";
  for (const list of document.querySelectorAll("#content details")) list.open = true;
  redraw();
});
addEventListener("afterprint", () => {
  delete document.documentElement.dataset.theme;
  redraw();
});
addEventListener("hashchange", unfold);
unfold();
follow();
