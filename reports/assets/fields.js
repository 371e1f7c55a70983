"use strict";

// Fields in two and three dimensions: points at their current positions, coloured by a quantity. All panels of a page share one
// WebGL context, because browsers allow few; without a graphics card the points are drawn on the processor.

{
  const VERTEX = `#version 300 es
    in vec4 point; // position in pixels, depth, and share of the scale, or -1 for a value that is not finite
    uniform vec2 frame;
    uniform float size;
    out float share;
    void main() {
      gl_Position = vec4(2.0 * point.x / frame.x - 1.0, 1.0 - 2.0 * point.y / frame.y, point.z, 1.0);
      gl_PointSize = point.w < 0.0 ? max(size, 9.0) : size;
      share = point.w;
    }`;
  const FRAGMENT = `#version 300 es
    precision highp float;
    in float share;
    uniform sampler2D ramp;
    uniform vec3 missing;
    uniform float size;
    out vec4 colour;
    void main() {
      vec2 place = 2.0 * gl_PointCoord - 1.0;
      if (share < 0.0) {
        if (min(abs(place.x - place.y), abs(place.x + place.y)) > 0.4) discard;
        colour = vec4(missing, 1.0);
        return;
      }
      float radius = length(place);
      if (radius > 1.0) discard;
      float cover = size < 5.0 ? 1.0 : clamp((1.0 - radius) * size * 0.5, 0.0, 1.0);
      colour = vec4(texture(ramp, vec2(share, 0.5)).rgb * cover, cover);
    }`;
  const TONES = 256;
  const MISSING = -1;
  const FEW = 5000; // points that are drawn as discs: smoother than pixels, and slower
  const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => [n & 1, (n >> 1) & 1, n >> 2]);

  const rgb = (colour) => [1, 3, 5].map((at) => Number.parseInt(colour.slice(at, at + 2), 16));

  /** Returns TONES colours, evenly mixed between the stops of a map, as bytes (r, g, b, 255). */
  function ramp(stops) {
    const table = new Uint8Array(4 * TONES);
    const ends = stops.map(rgb);
    for (let k = 0; k < TONES; k += 1) {
      const place = (k / (TONES - 1)) * (ends.length - 1);
      const first = Math.min(Math.floor(place), ends.length - 2);
      for (let c = 0; c < 3; c += 1) {
        table[4 * k + c] = Math.round(ends[first][c] + (ends[first + 1][c] - ends[first][c]) * (place - first));
      }
      table[4 * k + 3] = 255;
    }
    return table;
  }

  /** Draws points with WebGL into a canvas of its own. */
  class GraphicsPainter {
    constructor(gl) {
      this.gl = gl;
      const program = gl.createProgram();
      for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        gl.attachShader(program, shader);
      }
      gl.linkProgram(program);
      if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "WebGL");
      gl.useProgram(program);
      this.at = Object.fromEntries(["frame", "size", "missing"].map((name) => [name, gl.getUniformLocation(program, name)]));
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      const place = gl.getAttribLocation(program, "point");
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 4, gl.FLOAT, false, 0, 0);
      gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
      for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
      for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthFunc(gl.LEQUAL);
    }

    paint(context, scene, size, colours, missing, solid) {
      const { gl } = this;
      const { width, height } = context.canvas;
      if (gl.canvas.width < width || gl.canvas.height < height) {
        gl.canvas.width = Math.max(gl.canvas.width, width);
        gl.canvas.height = Math.max(gl.canvas.height, height);
      }
      gl.viewport(0, gl.canvas.height - height, width, height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      if (solid) gl.enable(gl.DEPTH_TEST);
      else gl.disable(gl.DEPTH_TEST);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, TONES, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, colours);
      gl.uniform2f(this.at.frame, width, height);
      gl.uniform1f(this.at.size, size);
      gl.uniform3fv(this.at.missing, rgb(missing).map((part) => part / 255));
      gl.bufferData(gl.ARRAY_BUFFER, scene.points, gl.STREAM_DRAW, 0, 4 * scene.count);
      gl.drawArrays(gl.POINTS, 0, scene.count);
      context.drawImage(gl.canvas, 0, 0, width, height, 0, 0, width, height);
    }
  }

  /** Draws points into the pixels of an image; in front of one another by the depth that each pixel has reached. */
  class PixelPainter {
    paint(context, scene, size, colours, missing, solid) {
      if (scene.count <= FEW) this.discs(context, scene, size, colours, missing, solid);
      else this.pixels(context, scene, size, colours, missing, solid);
    }

    /** Draws each point as a disc with smooth edges, the nearest last. */
    discs(context, { points, count }, size, colours, missing, solid) {
      const order = Uint32Array.from({ length: count }, (_, k) => k);
      if (solid) order.sort((a, b) => points[4 * b + 2] - points[4 * a + 2]);
      Object.assign(context, { strokeStyle: missing, lineWidth: Math.max(size, 9) / 5 });
      for (const k of order) {
        const [x, y, share] = [points[4 * k], points[4 * k + 1], points[4 * k + 3]];
        context.beginPath();
        if (share < 0) {
          const arm = Math.max(size, 9) / 3;
          for (const side of [-1, 1]) {
            context.moveTo(x - arm, y - side * arm);
            context.lineTo(x + arm, y + side * arm);
          }
          context.stroke();
          continue;
        }
        const tone = 4 * Math.round(share * (TONES - 1));
        context.fillStyle = `rgb(${colours[tone]} ${colours[tone + 1]} ${colours[tone + 2]})`;
        context.arc(x, y, size / 2, 0, 2 * Math.PI);
        context.fill();
      }
    }

    pixels(context, scene, size, colours, missing, solid) {
      const { width, height } = context.canvas;
      const image = context.createImageData(width, height);
      const pixels = new Uint32Array(image.data.buffer);
      const tones = new Uint32Array(colours.buffer);
      const marked = new Uint32Array(new Uint8Array([...rgb(missing), 255]).buffer)[0];
      const reached = solid ? new Float32Array(width * height).fill(Infinity) : null;
      for (let k = 0; k < scene.count; k += 1) {
        const x = scene.points[4 * k];
        const y = scene.points[4 * k + 1];
        const depth = scene.points[4 * k + 2];
        const share = scene.points[4 * k + 3];
        const lost = share < 0;
        const radius = Math.max((lost ? Math.max(size, 9) : size) / 2, 0.5);
        const paint = lost ? marked : tones[Math.round(share * (TONES - 1))];
        const [left, right] = [Math.max(Math.round(x - radius), 0), Math.min(Math.round(x + radius), width)];
        const bottom = Math.min(Math.round(y + radius), height);
        for (let row = Math.max(Math.round(y - radius), 0); row < bottom; row += 1) {
          const dy = row + 0.5 - y;
          for (let column = left; column < right; column += 1) {
            const dx = column + 0.5 - x;
            const drawn = lost ? Math.min(Math.abs(dx - dy), Math.abs(dx + dy)) < 0.4 * radius : dx * dx + dy * dy < radius * radius;
            const place = row * width + column;
            if (!(drawn || (!lost && size < 3)) || (reached && depth > reached[place])) continue;
            pixels[place] = paint;
            if (reached) reached[place] = depth;
          }
        }
      }
      const layer = document.createElement("canvas");
      [layer.width, layer.height] = [width, height];
      layer.getContext("2d").putImageData(image, 0, 0);
      context.drawImage(layer, 0, 0);
    }
  }

  let shared = null;
  const panels = new Map();

  /** Returns whether the processor does the work of the graphics card: it is faster without this detour. */
  function emulated(gl) {
    const detail = gl.getExtension("WEBGL_debug_renderer_info");
    const name = gl.getParameter(detail ? detail.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    return /swiftshader|llvmpipe|software|basic render/i.test(String(name));
  }

  function painter() {
    if (shared) return shared;
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: true, failIfMajorPerformanceCaveat: true });
    try {
      shared = gl && !emulated(gl) ? new GraphicsPainter(gl) : new PixelPainter();
    } catch {
      shared = new PixelPainter();
    }
    canvas.addEventListener("webglcontextlost", () => {
      shared = new PixelPainter();
      for (const panel of panels.values()) panel.draw();
    });
    return shared;
  }

  /** Values of one variable at all times: 16-bit integers, decoded where they are asked for. */
  class Column {
    constructor({ low, scale, data }, points) {
      Object.assign(this, { low, scale, points });
      const text = atob(data);
      const bytes = new Uint8Array(text.length);
      for (let k = 0; k < text.length; k += 1) bytes[k] = text.charCodeAt(k);
      this.steps = data ? new Int16Array(bytes.buffer) : null;
    }

    at(row, point) {
      if (!this.steps) return this.low;
      const step = this.steps[row * this.points + point];
      return step === -32768 ? Number.NaN : this.low + (step + 32767) * this.scale;
    }

    row(row) {
      const { points, steps, low, scale } = this;
      const values = new Float32Array(points);
      if (!steps) return values.fill(low);
      const first = row * points;
      for (let point = 0; point < points; point += 1) {
        const step = steps[first + point];
        values[point] = step === -32768 ? Number.NaN : low + (step + 32767) * scale;
      }
      return values;
    }
  }

  /** Points, times and quantities of one series. */
  class Body {
    constructor(data, stored) {
      Object.assign(this, data);
      this.stored = stored;
      this.reference = data.reference.map((part) => new Column(stored[part], data.shown));
      this.columns = new Map();
      this.rows = new Map();
      this.dimension = data.reference.length;
      this.moves = ["x", "y", "z"].slice(0, this.dimension).every((axis) => `displacement_${axis}` in data.fields);
    }

    column(key, part) {
      const name = `${key} ${part}`;
      if (!this.columns.has(name)) {
        const place = this.fields[key]?.[part];
        this.columns.set(name, place === undefined ? null : new Column(this.stored[place], this.shown));
      }
      return this.columns.get(name);
    }

    /** Returns one value of a quantity, in the "numerical" or "exact" field or the "error". */
    value(key, plot, row, point) {
      const at = (part) => this.column(key, part)?.at(row, point) ?? Number.NaN;
      if (plot !== "numerical") return at(plot);
      return this.column(key, "numerical") ? at("numerical") : at("exact") + at("error");
    }

    /** Writes one value with the digits that its encoding has. */
    written(key, plot, row, point) {
      const value = this.value(key, plot, row, point);
      const parts = plot === "numerical" && !this.column(key, "numerical") ? ["exact", "error"] : [plot];
      const step = Math.max(...parts.map((part) => this.column(key, part)?.scale ?? 0));
      if (Math.abs(value) < step) return "0";
      return shown(value, step ? Math.min(4, 1 + Math.floor(Math.log10(Math.abs(value) / step))) : 4);
    }

    /** Returns the values of all points at one time, kept until another time is asked for. */
    values(key, plot, row) {
      const name = `${key} ${plot}`;
      const kept = this.rows.get(name);
      if (kept?.row === row) return kept.values;
      const values = this.read(key, plot, row);
      this.rows.set(name, { row, values });
      return values;
    }

    read(key, plot, row) {
      const stored = this.column(key, plot);
      if (stored) return stored.row(row);
      const exact = this.column(key, "exact")?.row(row);
      const error = this.column(key, "error")?.row(row);
      if (plot !== "numerical" || !exact || !error) return new Float32Array(this.shown).fill(Number.NaN);
      for (let point = 0; point < this.shown; point += 1) exact[point] += error[point];
      return exact;
    }

    /** Returns the coordinates along one axis; those of a point whose displacement is not finite come from the exact field. */
    places(axis, plot, row) {
      const name = `place ${axis} ${plot}`;
      const kept = this.rows.get(name);
      if (kept?.row === row) return kept.values;
      const places = this.reference[axis].row(0);
      const key = `displacement_${"xyz"[axis]}`;
      const moved = this.moves ? this.values(key, plot, row) : null;
      const known = this.moves && plot === "numerical" ? this.values(key, "exact", row) : null;
      for (let point = 0; moved && point < this.shown; point += 1) {
        if (Number.isFinite(moved[point])) places[point] += moved[point];
        else if (known && Number.isFinite(known[point])) places[point] += known[point];
      }
      this.rows.set(name, { row, values: places });
      return places;
    }

    compared(key) {
      return this.column(key, "exact") !== null;
    }
  }

  /** Returns round numbers between two ends, at most about `most`. */
  function ticks(low, high, most) {
    if (!(high > low)) return [low];
    const raw = (high - low) / Math.max(most, 1);
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= raw * (1 - 1e-9));
    const table = [];
    for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k += 1) table.push(k * step);
    return table;
  }

  const SUPERSCRIPT = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
  const raised = (power) => `10${[...String(power)].map((letter) => SUPERSCRIPT[letter]).join("")}`;

  /** Formats a number to some digits: 0.0123, 1.23×10⁻⁵, −4. */
  function shown(value, digits = 4) {
    if (!Number.isFinite(value)) return "not finite";
    if (value === 0) return "0";
    const size = Math.abs(value);
    const [mantissa, power] = value.toExponential(digits - 1).split("e");
    const plain = size >= 1e-3 && size < 1e4;
    const text = plain ? String(Number(value.toPrecision(digits))) : `${Number(mantissa)}×${raised(Number(power))}`;
    return text.replace("-", "−");
  }

  /** Returns the power of ten that is written beside an axis instead of in each of its labels. */
  function common(low, high) {
    const size = Math.max(Math.abs(low), Math.abs(high));
    if (size === 0 || (size >= 1e-2 && size < 1e4)) return 0;
    return 3 * Math.floor(Math.log10(size) / 3 + 1e-9);
  }

  const label = (value, power) => String(Number((value / 10 ** power).toPrecision(4))).replace("-", "−");
  const units = (power, unit) => [power ? raised(power) : "", unit].filter(Boolean).join(" ");
  const bracketed = (text) => (text ? ` [${text}]` : "");
  const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;

  const svg = (name, attributes, text = "") => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    element.textContent = text;
    return element;
  };

  class Panel {
    constructor(section) {
      this.section = section;
      this.data = JSON.parse(section.querySelector("script.points").textContent);
      this.bodies = new Map();
      this.marked = null;
      this.timer = null;
      this.waiting = false;
      this.scenes = new Map();
      this.plots = new Map([...section.querySelectorAll("[data-plot]")].map((box) => [box.dataset.plot, box]));
      for (const part of section.querySelectorAll(".live")) part.hidden = false;
      section.querySelector(".field-still").classList.add("printed");
      this.prepare();
      this.chooseSeries();
      new ResizeObserver(() => this.ask()).observe(this.role("views"));
    }

    role(name) {
      return this.section.querySelector(`[data-role="field-${name}"]`);
    }

    prepare() {
      const on = (name, event, action) => this.role(name)?.addEventListener(event, action);
      on("series", "change", () => this.chooseSeries());
      on("quantity", "change", () => this.ask());
      on("view", "change", () => this.chooseView());
      for (const name of ["time", "depth", "turn", "tilt"]) on(name, "input", () => this.ask());
      on("play", "click", () => this.togglePlay());
      for (const [plot, box] of this.plots) {
        const canvas = box.querySelector("canvas");
        canvas.addEventListener("pointerdown", (event) => this.press(event, plot));
      }
      this.plots.get("numerical").querySelector("canvas").addEventListener("keydown", (event) => this.key(event));
    }

    get body() {
      const row = Number(this.role("series").value);
      if (!this.bodies.has(row)) this.bodies.set(row, new Body(this.data.series[row], this.data.columns));
      return this.bodies.get(row);
    }

    get quantity() {
      const chosen = this.role("quantity").value;
      return chosen in this.body.fields ? chosen : Object.keys(this.body.fields)[0];
    }

    get row() {
      return Math.min(Number(this.role("time").value), this.body.t.length - 1);
    }

    get view() {
      return this.role("view")?.value ?? "flat";
    }

    get axes() {
      return this.view === "flat" || this.view === "all" ? [0, 1] : [0, 1, 2].filter((axis) => axis !== Number(this.view));
    }

    chooseSeries() {
      const { body } = this;
      for (const option of this.role("quantity").options) option.disabled = !(option.value in body.fields);
      if (this.role("quantity").value !== this.quantity) this.role("quantity").value = this.quantity;
      const slider = this.role("time");
      this.role("times").hidden = body.t.length < 2;
      slider.max = String(body.t.length - 1);
      slider.value = String(body.start);
      this.marked = null;
      this.chooseView();
    }

    chooseView() {
      const slice = this.view !== "flat" && this.view !== "all";
      this.role("slice").hidden = !slice;
      this.role("orbit").hidden = this.view !== "all";
      if (slice) {
        const { low, layers } = this.layers();
        const slider = this.role("depth");
        slider.max = String(layers - 1);
        slider.value = String(Math.floor((layers - 1) / 2));
        slider.dataset.low = String(low);
      }
      this.ask();
    }

    /** Layers of points across the axis of the slice, one spacing thick. */
    layers() {
      const depth = this.body.reference[Number(this.view)].row(0);
      const low = depth.reduce((a, b) => Math.min(a, b));
      const high = depth.reduce((a, b) => Math.max(a, b));
      return { depth, low, layers: Math.max(1, Math.round((high - low) / this.body.spacing) + 1) };
    }

    /** Returns whether each point is in the slice; null if every point is shown. */
    inside() {
      if (this.view === "flat" || this.view === "all") return null;
      const { depth, low } = this.layers();
      const middle = low + Number(this.role("depth").value) * this.body.spacing;
      const half = this.body.spacing * 0.501;
      const axis = "xyz"[Number(this.view)];
      this.role("place").textContent = `${axis.toUpperCase()} = ${shown(middle, 3)} m in the reference state`;
      this.role("depth").setAttribute("aria-valuetext", this.role("place").textContent);
      return depth.map((value) => (Math.abs(value - middle) <= half ? 1 : 0));
    }

    ask() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        this.draw();
      });
    }

    // Drawing

    draw() {
      const { body, quantity: key, row } = this;
      const compared = body.compared(key);
      const colours = this.data.palettes[dark() ? "dark" : "light"];
      const field = body.fields[key];
      const inside = this.inside();
      const scales = {
        value: { low: field.low, high: field.high, stops: field.signed ? colours.signed : colours.rising },
        error: { low: -field.reach, high: field.reach, stops: colours.signed },
      };
      const counts = { missing: 0, beyond: 0, outside: 0 };
      this.arrange(compared);
      for (const [plot, box] of this.plots) {
        box.hidden = plot !== "numerical" && !compared;
        if (!box.hidden) this.plot(plot, box, plot === "error" ? scales.error : scales.value, inside, colours, counts);
      }
      const { name, unit } = this.data.quantities[key];
      this.bar("value", scales.value, name, unit);
      this.bar("error", scales.error, `difference, ${name}`, unit, !compared);
      this.role("clock").textContent = `t = ${shown(body.t[row])} s`;
      this.role("time").setAttribute("aria-valuetext", this.role("clock").textContent);
      this.note(counts, field);
      this.tell();
    }

    /** Puts the views side by side, or below one another where the page is narrow or the body long. */
    arrange(compared) {
      const views = this.role("views");
      const [width, height] = this.extent();
      const stacked = views.clientWidth < 640 || width > 2.4 * height;
      views.classList.toggle("stacked", stacked);
      views.classList.toggle("alone", !compared);
    }

    /** Returns the width and height of the view [m]. */
    extent() {
      const size = this.body.view.map(([low, high]) => high - low);
      if (this.view === "all") return [Math.hypot(...size), Math.hypot(...size)];
      return this.axes.map((axis) => size[axis]);
    }

    /** Returns what turns positions into pixels: the scale and the corner, and in the view of all points the rotation. */
    frame(canvas) {
      const [width, height] = this.extent();
      const turned = this.view === "all";
      const margin = turned ? { left: 8, right: 8, top: 8, bottom: 8 } : { left: 48, right: 10, top: 10, bottom: 36 };
      const inner = Math.max(canvas.parentElement.clientWidth - margin.left - margin.right, 60);
      const factor = Math.min(inner / width, (turned ? 420 : 470) / height);
      const css = { width: inner + margin.left + margin.right, height: Math.ceil(factor * height) + margin.top + margin.bottom };
      const ratio = Math.min(devicePixelRatio || 1, 2);
      const left = margin.left + (turned ? (inner - factor * width) / 2 : 0);
      return { width, height, factor, margin, css, ratio, left, turned };
    }

    rotation() {
      const [turn, tilt] = ["turn", "tilt"].map((name) => (Number(this.role(name).value) * Math.PI) / 180);
      const [c, s, a, b] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
      return [
        [c, 0, s],
        [s * b, a, -c * b],
        [s * a, -b, -c * a],
      ];
    }

    /** Returns the rows of the affine map from positions to pixels and depth: a constant, then a factor for each axis. */
    projection(frame) {
      const { view, dimension } = this.body;
      const scale = frame.factor * frame.ratio;
      const none = () => new Array(dimension + 1).fill(0);
      if (!frame.turned) {
        const [across, down, deep] = [none(), none(), none()];
        const [a, b] = this.axes;
        const base = (frame.css.height - frame.margin.bottom) * frame.ratio;
        [across[0], across[a + 1]] = [frame.left * frame.ratio - view[a][0] * scale, scale];
        [down[0], down[b + 1]] = [base + view[b][0] * scale, -scale];
        return [across, down, deep];
      }
      const line = (start, factor, parts) => {
        const factors = parts.map((part) => part * factor);
        return [factors.reduce((sum, part, axis) => sum - (part * (view[axis][0] + view[axis][1])) / 2, start), ...factors];
      };
      const [across, up, deep] = this.rotation();
      const [x, y] = [frame.css.width, frame.css.height].map((size) => (size / 2) * frame.ratio);
      return [line(x, scale, across), line(y, -scale, up), line(0, 1 / frame.width, deep)];
    }

    plot(plot, box, scale, inside, colours, counts) {
      const canvas = box.querySelector("canvas");
      const frame = this.frame(canvas);
      const [width, height] = [frame.css.width, frame.css.height].map((size) => Math.round(size * frame.ratio));
      if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
      canvas.style.height = `${frame.css.height}px`;
      const context = canvas.getContext("2d");
      context.clearRect(0, 0, width, height);
      const projection = this.projection(frame);
      this.grid(context, frame, projection);
      const scene = this.scene(plot, scale, inside, projection, width, height, counts);
      this.scenes.set(plot, scene);
      const apart = this.body.spacing * frame.factor * frame.ratio;
      const size = Math.max(apart * (apart > 9 * frame.ratio ? 0.94 : 1.45), 1.5 * frame.ratio);
      scene.size = size;
      if (scene.count) painter().paint(context, scene, size, ramp(scale.stops), colours.missing, frame.turned);
      this.ring(context, scene, frame);
    }

    /** Returns room for the points of one view, the same at every frame. */
    space(plot, shown) {
      const kept = this.scenes.get(plot);
      if (kept?.index.length === shown) return kept;
      return { points: new Float32Array(4 * shown), index: new Uint32Array(shown) };
    }

    /** Returns the points of one view for the painter; those that are not finite come last, so that they are seen. */
    scene(plot, scale, inside, projection, width, height, counts) {
      const { body, quantity: key, row } = this;
      const where = plot === "exact" ? "exact" : "numerical";
      const places = body.reference.map((_, axis) => body.places(axis, where, row));
      const values = body.values(key, plot, row);
      const { points, index } = this.space(plot, body.shown);
      const [across, down, deep] = projection;
      const [xs, ys, zs] = [places[0], places[1], places[2] ?? places[0]];
      const third = (line) => line[3] ?? 0;
      const [ax, ay, az] = [across, down, deep].map(third);
      const { low } = scale;
      const range = scale.high - scale.low;
      let [front, back] = [0, body.shown];
      for (let point = 0; point < body.shown; point += 1) {
        if (inside && !inside[point]) continue;
        const x = across[0] + across[1] * xs[point] + across[2] * ys[point] + ax * zs[point];
        const y = down[0] + down[1] * xs[point] + down[2] * ys[point] + ay * zs[point];
        if (!(x >= 0 && x <= width && y >= 0 && y <= height)) {
          if (plot === "numerical") counts.outside += 1;
          continue;
        }
        const value = values[point];
        const finite = Number.isFinite(value);
        const share = range > 0 ? (value - low) / range : 0.5;
        if (plot === "numerical" && !finite) counts.missing += 1;
        if (plot === "numerical" && finite && (share < -1e-3 || share > 1.001)) counts.beyond += 1;
        const place = finite ? front : back - 1;
        if (finite) front += 1;
        else back -= 1;
        points[4 * place] = x;
        points[4 * place + 1] = y;
        points[4 * place + 2] = deep[0] + deep[1] * xs[point] + deep[2] * ys[point] + az * zs[point];
        points[4 * place + 3] = finite ? Math.min(Math.max(share, 0), 1) : MISSING;
        index[place] = point;
      }
      points.copyWithin(4 * front, 4 * back);
      index.copyWithin(front, back);
      return { points, index, count: front + body.shown - back };
    }

    grid(context, frame, projection) {
      const sheet = getComputedStyle(this.section);
      const [muted, line] = ["--muted", "--line"].map((name) => sheet.getPropertyValue(name).trim());
      context.save();
      context.scale(frame.ratio, frame.ratio);
      Object.assign(context, { font: `11px ${sheet.fontFamily}`, fillStyle: muted, strokeStyle: line, lineWidth: 1 });
      if (frame.turned) this.box(context, frame, projection);
      else this.scales(context, frame);
      context.restore();
    }

    scales(context, frame) {
      const { view } = this.body;
      const [a, b] = this.axes;
      const base = frame.css.height - frame.margin.bottom;
      const [right, top] = [frame.left + frame.width * frame.factor, base - frame.height * frame.factor];
      context.strokeRect(frame.left, top, right - frame.left, base - top);
      context.textAlign = "center";
      for (const value of ticks(...view[a], Math.max((right - frame.left) / 52, 2))) {
        const x = frame.left + (value - view[a][0]) * frame.factor;
        context.fillRect(x - 0.5, base, 1, 4);
        context.fillText(label(value, 0), x, base + 15);
      }
      context.fillText(`${"xyz"[a]} [m]`, (frame.left + right) / 2, base + 31);
      context.textAlign = "right";
      for (const value of ticks(...view[b], Math.max((base - top) / 36, 2))) {
        const y = base - (value - view[b][0]) * frame.factor;
        context.fillRect(frame.left - 4, y - 0.5, 4, 1);
        context.fillText(label(value, 0), frame.left - 7, y + 4);
      }
      context.textAlign = "center";
      context.translate(10, (top + base) / 2);
      context.rotate(-Math.PI / 2);
      context.fillText(`${"xyz"[b]} [m]`, 0, 0);
    }

    /** Draws the box of the view, with the names of its axes at the ends of three edges. */
    box(context, frame, projection) {
      const { view } = this.body;
      const pixel = (corner) => {
        const along = (line) => corner.reduce((sum, end, axis) => sum + line[axis + 1] * view[axis][end], line[0]);
        return projection.slice(0, 2).map((line) => along(line) / frame.ratio);
      };
      context.beginPath();
      for (const corner of CORNERS) {
        for (let axis = 0; axis < 3; axis += 1) {
          if (corner[axis]) continue;
          const other = corner.map((end, k) => (k === axis ? 1 : end));
          context.moveTo(...pixel(corner));
          context.lineTo(...pixel(other));
        }
      }
      context.stroke();
      context.textAlign = "center";
      for (let axis = 0; axis < 3; axis += 1) {
        const end = [0, 0, 0];
        end[axis] = 1;
        const [x, y] = pixel(end);
        context.fillText("xyz"[axis], Math.min(Math.max(x, 8), frame.css.width - 8), Math.min(Math.max(y + 14, 12), frame.css.height - 4));
      }
    }

    ring(context, scene, frame) {
      const place = this.marked === null ? -1 : scene.index.subarray(0, scene.count).indexOf(this.marked);
      if (place < 0) return;
      const sheet = getComputedStyle(this.section);
      const [x, y] = scene.points.subarray(4 * place, 4 * place + 2);
      const radius = Math.max(scene.size / 2 + 2 * frame.ratio, 5 * frame.ratio);
      for (const [name, width] of [["--panel", 5], ["--ink", 2]]) {
        Object.assign(context, { strokeStyle: sheet.getPropertyValue(name).trim(), lineWidth: width * frame.ratio });
        context.beginPath();
        context.arc(x, y, radius, 0, 2 * Math.PI);
        context.stroke();
      }
    }

    bar(name, { low, high, stops }, title, unit, hidden = false) {
      const box = this.section.querySelector(`[data-bar="${name}"]`);
      const make = (kind, text) => {
        const part = document.createElement("span");
        part.className = kind;
        part.textContent = text;
        return part;
      };
      box.hidden = hidden;
      const power = common(low, high);
      const strip = make("ramp", "");
      strip.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
      const marks = make("marks", "");
      for (const value of high > low ? ticks(low, high, 5) : [low]) {
        const mark = make("mark", label(value, power));
        mark.style.left = `${high > low ? (100 * (value - low)) / (high - low) : 50}%`;
        marks.append(mark);
      }
      box.replaceChildren(make("title", title + bracketed(units(power, unit))), strip, marks);
    }

    note({ missing, beyond, outside }, field) {
      const { body } = this;
      const parts = [body.count, `level h = ${body.h} m`];
      if (body.t.length < 2) parts.push(`t = ${shown(body.t[0])} s`);
      const lines = [`${parts.join(", ")}.`];
      const counted = (number) => `${number} ${number === 1 ? "point" : "points"}`;
      if (missing) lines.push(`Crosses: ${counted(missing)} whose value is not finite.`);
      if (beyond) lines.push(`Beyond the scale, in the colour of its end: ${counted(beyond)} of the numerical field.`);
      if (outside) lines.push(`Outside the view: ${counted(outside)}.`);
      if (field.cut) lines.push(`Error cut off at ten times the size of the field: ${counted(field.cut)}.`);
      this.role("note").textContent = lines.join(" ");
      this.role("note").classList.toggle("marked", missing > 0);
    }

    // The marked point

    press(event, plot) {
      const canvas = event.currentTarget;
      if (this.view === "all") this.drag(event, canvas);
      const scene = this.scenes.get(plot);
      const ratio = canvas.width / canvas.clientWidth;
      const near = this.nearest(scene, event.offsetX * ratio, event.offsetY * ratio, Math.max(scene.size, 14 * ratio));
      if (near !== null) this.mark(near);
    }

    drag(event, canvas) {
      let [x, y] = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
      const move = (now) => {
        const add = (name, step) => {
          const slider = this.role(name);
          slider.step = "any";
          slider.value = String(Number(slider.value) + step);
        };
        add("turn", (now.clientX - x) / 2);
        add("tilt", (now.clientY - y) / 2);
        [x, y] = [now.clientX, now.clientY];
        this.ask();
      };
      canvas.addEventListener("pointermove", move);
      canvas.addEventListener("lostpointercapture", () => canvas.removeEventListener("pointermove", move), { once: true });
    }

    nearest(scene, x, y, reach) {
      let [best, found] = [reach * reach, null];
      for (let k = 0; k < scene.count; k += 1) {
        const distance = (scene.points[4 * k] - x) ** 2 + (scene.points[4 * k + 1] - y) ** 2;
        if (distance <= best) [best, found] = [distance, scene.index[k]];
      }
      return found;
    }

    key(event) {
      const scene = this.scenes.get("numerical");
      const steps = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      if (!scene?.count || !(event.key in steps || ["PageUp", "PageDown", "Home", "End", "Escape"].includes(event.key))) return;
      event.preventDefault();
      const order = [...scene.index.subarray(0, scene.count)].sort((a, b) => a - b);
      const at = order.indexOf(this.marked);
      if (event.key === "Escape") this.mark(null);
      else if (event.key === "Home") this.mark(order[0]);
      else if (event.key === "End") this.mark(order.at(-1));
      else if (event.key === "PageDown") this.mark(order[Math.min(at + 1, order.length - 1)]);
      else if (event.key === "PageUp") this.mark(order[Math.max(at - 1, 0)]);
      else this.mark(this.beside(scene, ...steps[event.key]));
    }

    /** Returns the nearest point in a direction from the marked one, or the one in the middle of the view if none is marked. */
    beside(scene, dx, dy) {
      const place = scene.index.subarray(0, scene.count).indexOf(this.marked ?? -1);
      const canvas = this.plots.get("numerical").querySelector("canvas");
      if (this.marked === null || place < 0) return this.nearest(scene, canvas.width / 2, canvas.height / 2, Infinity);
      const [x, y] = scene.points.subarray(4 * place, 4 * place + 2);
      let [best, found] = [Infinity, this.marked];
      for (let k = 0; k < scene.count; k += 1) {
        const [px, py] = [scene.points[4 * k] - x, scene.points[4 * k + 1] - y];
        const along = px * dx + py * dy;
        const aside = Math.abs(px * dy) + Math.abs(py * dx);
        if (along > 0.5 && aside <= along && along + 2 * aside < best) [best, found] = [along + 2 * aside, scene.index[k]];
      }
      return found;
    }

    mark(point) {
      this.marked = point;
      this.ask();
    }

    /** Writes the values of the marked point, and draws their history if there are several output times. */
    tell() {
      const { body, quantity: key, row, marked } = this;
      this.role("pick").hidden = marked === null;
      if (marked === null) return;
      const place = body.reference.map((column, axis) => `${"XYZ"[axis]} = ${shown(column.at(0, marked), 3)} m`).join(", ");
      const { name, unit } = this.data.quantities[key];
      const said = (plot) => body.written(key, plot, row, marked);
      const parts = [`Point ${marked + 1} (${place}) at t = ${shown(body.t[row])} s: ${name} ${said("numerical")} ${unit}`];
      if (body.compared(key)) parts.push(`exact ${said("exact")} ${unit}`, `difference ${said("error")} ${unit}`);
      this.role("words").textContent = `${parts.map((part) => part.trim()).join("; ")}.`;
      const rows = Object.keys(body.fields).map((each) => this.line(each, row, marked, each === key));
      this.role("values").replaceChildren(...rows);
      this.role("history").replaceChildren(...(body.t.length > 1 ? [this.history(key, marked)] : []));
    }

    line(key, row, point, current) {
      const { name, unit } = this.data.quantities[key];
      const line = document.createElement("tr");
      const cell = (kind, text, numeric) => {
        const part = document.createElement(kind);
        part.textContent = text;
        if (numeric) part.className = "number";
        else if (kind === "th") part.scope = "row";
        line.append(part);
      };
      cell("th", name, false);
      for (const plot of ["numerical", "exact", "error"]) {
        const known = plot === "numerical" || this.body.compared(key);
        cell("td", known ? this.body.written(key, plot, row, point) : "–", true);
      }
      cell("td", unit, false);
      line.classList.toggle("current", current);
      return line;
    }

    history(key, point) {
      const { body, row } = this;
      const { name, unit } = this.data.quantities[key];
      const [width, height, left, right, top, bottom] = [420, 180, 58, 12, 8, 34];
      const curves = ["exact", "numerical"].map((plot) => body.t.map((_, k) => body.value(key, plot, k, point)));
      const finite = curves.flat().filter(Number.isFinite);
      let [low, high] = [Math.min(...finite), Math.max(...finite)];
      if (!(high > low)) [low, high] = [low - (Math.abs(low) || 1) / 2, low + (Math.abs(low) || 1) / 2];
      const [first, last] = [body.t[0], body.t.at(-1)];
      const across = (t) => left + ((t - first) / (last - first)) * (width - left - right);
      const down = (value) => top + ((high - value) / (high - low)) * (height - top - bottom);
      const power = common(low, high);
      const text = `${name}${bracketed(units(power, unit))} of point ${point + 1} over time`;
      const picture = svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "field-history", role: "img", "aria-label": text });
      const caption = document.createElement("figcaption");
      caption.textContent = body.compared(key) ? `${text}; dashed: exact` : text;
      const box = document.createElement("figure");
      box.append(caption, picture);
      if (!finite.length) return box;
      for (const value of ticks(low, high, 6)) {
        picture.append(svg("path", { class: "grid", d: `M${left} ${down(value)}H${width - right}` }));
        picture.append(svg("text", { x: left - 6, y: down(value) + 4, "text-anchor": "end" }, label(value, power)));
      }
      for (const value of ticks(first, last, 5)) {
        picture.append(svg("text", { x: across(value), y: height - bottom + 16, "text-anchor": "middle" }, label(value, 0)));
      }
      picture.append(svg("text", { x: width - right, y: height - 4, "text-anchor": "end" }, "t [s]"));
      picture.append(svg("path", { class: "now", d: `M${across(body.t[row])} ${top}V${height - bottom}` }));
      curves.forEach((values, k) => {
        const steps = values.map((value, n) => [across(body.t[n]), down(value)]);
        let line = "";
        steps.forEach(([x, y], n) => {
          if (Number.isFinite(y)) line += `${n && Number.isFinite(steps[n - 1][1]) ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`;
        });
        picture.append(svg("path", { class: ["exact", "numerical"][k], d: line }));
      });
      return box;
    }

    togglePlay() {
      const [button, slider] = [this.role("play"), this.role("time")];
      const playing = this.timer === null;
      button.setAttribute("aria-pressed", String(playing));
      button.textContent = playing ? "Pause" : "Play";
      if (!playing) {
        clearInterval(this.timer);
        this.timer = null;
        return;
      }
      if (slider.value === slider.max) slider.value = "0";
      this.ask();
      this.timer = setInterval(() => {
        slider.value = String(Number(slider.value) + 1);
        this.ask();
        if (slider.value === slider.max) this.togglePlay();
      }, 220);
    }
  }

  const near = new IntersectionObserver(
    (entries) => {
      for (const { isIntersecting, target } of entries) {
        if (!isIntersecting || panels.has(target)) continue;
        near.unobserve(target);
        panels.set(target, new Panel(target));
      }
    },
    { rootMargin: "300px" },
  );
  for (const section of document.querySelectorAll("[data-points]")) near.observe(section);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const panel of panels.values()) panel.draw();
  });
}
