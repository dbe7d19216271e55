// Plays points in time: each element of class "player" holds its data as JSON, which crates/plots/src/animation/mod.rs writes.
"use strict";
(function () {
  const INK = "#1d2733", SOFT = "#5c6b7a", LINE = "#c9d2da", NONE = "#aaaaaa", FONT = "12px system-ui, sans-serif";
  const PLACES = 65535, VALUES = 254;
  const element = (parent, name, attributes, text) => {
    const made = document.createElement(name);
    for (const key in attributes || {}) made.setAttribute(key, attributes[key]);
    if (text) made.textContent = text;
    parent.append(made);
    return made;
  };
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const words = (text) => {
    const raw = bytes(text), made = new Uint16Array(raw.length / 2);
    for (let k = 0; k < made.length; k++) made[k] = raw[2 * k] + 256 * raw[2 * k + 1];
    return made;
  };

  // Round numbers that divide a range into about `wanted` parts.
  function ticks(low, high, wanted) {
    const rough = (high - low) / wanted, power = Math.pow(10, Math.floor(Math.log10(rough)));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999), found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
    const digits = Math.max(0, Math.min(12, -Math.floor(Math.log10(step) + 1e-9)));
    const large = Math.max(Math.abs(low), Math.abs(high)), plain = digits < 6 && large * Math.pow(10, digits) < 1e9;
    return found.map((at) => [at, plain ? at.toFixed(digits) : at === 0 ? "0" : at.toExponential(1)]);
  }

  // A time with the digits that its neighbours need.
  function clock(time, end) {
    const digits = Math.max(0, Math.min(9, 2 - Math.floor(Math.log10(end || 1))));
    return "t = " + time.toFixed(digits) + " s";
  }

  function mix(stops, share) {
    const place = Math.min(1, Math.max(0, share)) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(place));
    const part = (c) => Math.round(stops[k][c] + (stops[k + 1][c] - stops[k][c]) * (place - k));
    return [part(0), part(1), part(2)];
  }

  // The colour of each number of a value.
  function colours(data, field) {
    const all = [];
    for (let k = 0; k <= 255; k++) {
      if (field.classes) all.push(data.palette[k % data.palette.length]);
      else all.push(k > VALUES ? [170, 170, 170] : mix(data.colours, k / VALUES));
    }
    return all;
  }
  const css = (c, light) => {
    const l = light || 0;
    return "rgb(" + c.map((v) => Math.round(v + (255 - v) * l)).join(",") + ")";
  };

  class Player {
    constructor(root) {
      this.root = root;
      this.data = JSON.parse(root.querySelector("script").textContent);
      this.now = this.data.times.length - 1;
      this.field = 0;
      this.yaw = -0.6;
      this.pitch = 0.5;
      this.solid = this.data.axes.length === 3;
      this.decoded = new Map();
      this.build();
      this.paint();
      new ResizeObserver(() => this.paint()).observe(root);
    }

    build() {
      const root = this.root, data = this.data;
      root.tabIndex = 0;
      const panels = element(root, "div", { class: "panels" + (this.solid ? " turned" : "") });
      this.canvases = data.panels.map((panel) => {
        const figure = element(panels, "figure", { class: "panel" });
        if (data.panels.length > 1) element(figure, "h4", {}, panel.name);
        return element(figure, "canvas", { role: "img", "aria-label": panel.name });
      });
      const bar = element(root, "div", { class: "bar" });
      this.button = element(bar, "button", { type: "button" }, "Play");
      this.slider = element(bar, "input", { type: "range", min: 0, max: data.times.length - 1, step: 1, "aria-label": "time" });
      this.label = element(bar, "span", { class: "time" });
      this.select = element(bar, "select", { "aria-label": "field" });
      data.fields.forEach((field, k) => element(this.select, "option", { value: k }, field.name));
      this.select.hidden = data.fields.length < 2;
      this.legend = element(element(root, "div", { class: "legend" }), "canvas", { role: "img", "aria-label": "scale" });
      const keys = "Space plays, arrow keys step" + (this.solid ? ", drag turns" : "") + ".";
      const said = element(root, "p", { class: "said" });
      this.note = element(said, "strong");
      const missing = data.missing ? "Not drawn: " + data.missing + ". " : "";
      said.append((data.thinned ? "Shown: " + data.thinned + ". " : "") + missing + keys);
      this.listen();
    }

    listen() {
      this.button.addEventListener("click", () => this.play(!this.timer));
      this.slider.addEventListener("input", () => { this.play(false); this.go(Number(this.slider.value)); });
      this.select.addEventListener("change", () => { this.field = Number(this.select.value); this.paint(); });
      this.root.addEventListener("keydown", (event) => {
        const steps = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity };
        if (event.target === this.select || (event.key === " " && event.target === this.button)) return;
        if (event.key === " ") this.play(!this.timer);
        else if (event.key in steps) { this.play(false); this.go(this.now + steps[event.key]); }
        else return;
        event.preventDefault();
      });
      if (this.solid) this.canvases.forEach((canvas) => this.turn(canvas));
    }

    turn(canvas) {
      let from = null;
      canvas.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
      canvas.addEventListener("pointerup", () => { from = null; });
      canvas.addEventListener("pointermove", (event) => {
        if (!from) return;
        this.yaw += 0.01 * (event.clientX - from[0]);
        this.pitch = Math.max(-0.2, Math.min(1.55, this.pitch + 0.01 * (event.clientY - from[1])));
        from = [event.clientX, event.clientY];
        this.paint();
      });
    }

    play(on) {
      clearInterval(this.timer);
      this.timer = null;
      this.button.textContent = on ? "Pause" : "Play";
      if (!on) return;
      if (this.now === this.data.times.length - 1) this.go(0);
      const pause = Math.min(400, Math.max(40, 6000 / this.data.times.length));
      this.timer = setInterval(() => {
        if (this.now < this.data.times.length - 1) this.go(this.now + 1);
        else this.play(false);
      }, pause);
    }

    go(to) {
      this.now = Math.max(0, Math.min(this.data.times.length - 1, to));
      this.paint();
    }

    // Places and widths in metres, numbers of the values.
    frame(panel, number) {
      const key = panel + ":" + number;
      if (!this.decoded.has(key)) {
        const data = this.data, frames = data.panels[panel].frames, frame = frames[number], dim = data.axes.length;
        let before = number;
        while (frames[before].w === null && before > 0) before--;
        const x = Float32Array.from(words(frame.x), (q, k) => {
          const c = k % dim;
          return data.low[c] + (q / PLACES) * (data.high[c] - data.low[c]);
        });
        const w = Float32Array.from(words(frames[before].w || ""), (q) => (q / PLACES) * data.largest);
        this.decoded.set(key, { n: frame.n, x, w, v: frame.v.map(bytes) });
        if (this.decoded.size > 400) this.decoded.delete(this.decoded.keys().next().value);
      }
      return this.decoded.get(key);
    }

    paint() {
      const data = this.data, time = data.times[this.now];
      this.root.dataset.frame = this.now;
      this.slider.value = this.now;
      this.label.textContent = clock(time, data.times[data.times.length - 1]);
      this.colours = colours(data, data.fields[this.field]);
      this.canvases.forEach((canvas, k) => {
        const frame = this.frame(k, data.panels[k].at[this.now]), shape = data.panels[k].shape;
        if (this.solid) this.paint3(canvas, frame, shape);
        else this.paint2(canvas, frame, shape);
      });
      this.scale();
    }

    // A canvas of the width that it has on the page; its pen, in CSS pixels.
    pen(canvas, height) {
      const width = Math.max(120, canvas.parentElement.clientWidth), dots = window.devicePixelRatio || 1;
      canvas.width = Math.round(width * dots);
      canvas.height = Math.round(height * dots);
      canvas.style.height = height + "px";
      const pen = canvas.getContext("2d");
      pen.setTransform(dots, 0, 0, dots, 0, 0);
      pen.fillStyle = "#fff";
      pen.fillRect(0, 0, width, height);
      pen.font = FONT;
      return [pen, width];
    }

    paint2(canvas, frame, shape) {
      const [low, high] = [this.data.low, this.data.high], left = 52, below = 36, above = 8;
      const width = Math.max(120, canvas.parentElement.clientWidth), room = width - left - 12;
      const spread = [high[0] - low[0], high[1] - low[1]];
      const scale = Math.min(room / spread[0], 440 / spread[1]);
      const stretch = this.stretch(scale * spread[1]), up = scale * stretch;
      const tall = Math.max(60, up * spread[1]), [pen] = this.pen(canvas, tall + below + above);
      const X = (x) => left + (x - low[0]) * scale, Y = (y) => above + tall - (y - low[1]) * up;
      this.axes2(pen, X, Y, tall, above, left);
      this.lines(pen, X, Y, tall, above);
      const v = frame.v[this.field];
      if (shape === "depth") return this.flow(pen, frame, v, X, Y, scale);
      for (let k = 0; k < frame.n; k++) {
        const x = X(frame.x[2 * k]), y = Y(frame.x[2 * k + 1]);
        const w = Math.max(1.2, scale * frame.w[2 * k]), h = Math.max(1.2, scale * frame.w[2 * k + 1]);
        pen.fillStyle = css(this.colours[v[k]]);
        if (shape === "disk") { pen.beginPath(); pen.arc(x, y, w / 2, 0, 7); pen.fill(); }
        else pen.fillRect(x - w / 2, y - h / 2, w, h);
      }
    }

    // How many times heights are drawn: a flow over its bed may be thousands of times as long as it is deep.
    stretch(tall) {
      const flat = this.data.panels.every((panel) => panel.shape === "depth") && tall < 100;
      const times = flat ? Math.min(100, Math.max(1, Math.floor(150 / Math.max(tall, 1e-9)))) : 1;
      this.note.textContent = times > 1 ? "Heights are stretched " + times + " times. " : "";
      return times;
    }

    axes2(pen, X, Y, tall, above, left) {
      const { low, high, axes } = this.data, base = above + tall, right = X(high[0]);
      pen.strokeStyle = LINE;
      pen.fillStyle = SOFT;
      pen.strokeRect(left, above, right - left, tall);
      pen.textAlign = "center";
      for (const [at, text] of ticks(low[0], high[0], Math.max(2, (right - left) / 90))) {
        pen.fillRect(X(at) - 0.5, base, 1, 4);
        pen.fillText(text, X(at), base + 15);
      }
      pen.fillText(axes[0] + " (m)", (left + right) / 2, base + 31);
      pen.textAlign = "right";
      for (const [at, text] of ticks(low[1], high[1], Math.max(1, Math.min(6, tall / 40)))) {
        pen.fillRect(left - 4, Y(at) - 0.5, 4, 1);
        pen.fillText(text, left - 6, Y(at) + 4);
      }
      pen.save();
      pen.translate(11, above + tall / 2);
      pen.rotate(-Math.PI / 2);
      pen.textAlign = "center";
      pen.fillText(axes[1] + " (m)", 0, 0);
      pen.restore();
    }

    // Rigid geometry, within the axes.
    lines(pen, X, Y, tall, above) {
      const { low, high, ground } = this.data;
      pen.save();
      pen.beginPath();
      pen.rect(X(low[0]), above, X(high[0]) - X(low[0]), tall);
      pen.clip();
      pen.strokeStyle = "#7a5c3a";
      pen.lineWidth = 1.5;
      const draw = (lines, [x0, y0, c, s]) => {
        for (const line of lines) {
          pen.beginPath();
          for (const [x, y] of line) pen.lineTo(X(x0 + c * x - s * y), Y(y0 + s * x + c * y));
          pen.stroke();
        }
      };
      draw(ground.lines, [0, 0, 1, 0]);
      for (const one of ground.moving) draw(one.lines, one.poses[this.now]);
      pen.restore();
    }

    // A flow over its bed: columns joined to a body, its surface and its bed drawn as lines.
    flow(pen, frame, v, X, Y, scale) {
      const order = Array.from({ length: frame.n }, (_, k) => k).sort((a, b) => frame.x[2 * a] - frame.x[2 * b]);
      const place = (k) => {
        const half = frame.w[2 * k + 1] / 2, y = frame.x[2 * k + 1];
        return { x: X(frame.x[2 * k]), bed: Y(y - half), top: Y(y + half), w: frame.w[2 * k] };
      };
      for (let j = 0; j + 1 < order.length; j++) {
        const a = place(order[j]), b = place(order[j + 1]), apart = (b.x - a.x) / scale;
        if (apart > 2 * (a.w + b.w)) continue;
        pen.fillStyle = css(this.colours[v[order[j]]]);
        pen.beginPath();
        for (const [x, y] of [[a.x, a.bed], [a.x, a.top], [b.x + 0.6, b.top], [b.x + 0.6, b.bed]]) pen.lineTo(x, y);
        pen.fill();
        for (const [key, colour] of [["bed", "#7a5c3a"], ["top", INK]]) {
          pen.strokeStyle = colour;
          pen.beginPath();
          pen.moveTo(a.x, a[key]);
          pen.lineTo(b.x, b[key]);
          pen.stroke();
        }
      }
    }

    // From places to the picture, seen along the view; `up` stands upright.
    camera(width, height) {
      const { low, high } = this.data, up = this.data.up === null ? 2 : this.data.up;
      const [a, b] = [[1, 2], [2, 0], [0, 1]][up];
      const centre = low.map((l, c) => (l + high[c]) / 2);
      const size = Math.hypot(...low.map((l, c) => high[c] - l)) || 1, scale = 0.9 * Math.min(width, 1.35 * height) / size;
      const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw), cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
      const project = (p) => {
        const u = p[a] - centre[a], w = p[b] - centre[b], h = p[up] - centre[up];
        const right = cy * u - sy * w, away = sy * u + cy * w;
        return [width / 2 + scale * right, height / 2 - scale * (h * cp + away * sp), (away * cp - h * sp) / size];
      };
      return { project, scale, up };
    }

    // Whether a place is drawn: not far from what the points cover.
    near(p, up) {
      const { low, high } = this.data, widest = Math.max(...high.map((h, c) => h - low[c]));
      return p.every((x, c) => {
        const room = c === up ? 0.3 * widest : 0.08 * widest;
        return x >= low[c] - room && x <= high[c] + room;
      });
    }

    // Pieces of the ground near what the points cover: corners, and how light they are.
    ground() {
      if (this.pieces) return this.pieces;
      const heights = this.data.ground.heights, up = this.data.up === null ? 2 : this.data.up;
      this.pieces = [];
      if (!heights) return this.pieces;
      const numbers = words(heights.values), [nu, nv] = heights.counts, [a, b] = [0, 1, 2].filter((c) => c !== up);
      const place = (i, j) => {
        const number = numbers[i + j * nu], p = [0, 0, 0];
        p[a] = heights.origin[0] + i * heights.spacing[0];
        p[b] = heights.origin[1] + j * heights.spacing[1];
        p[up] = number === PLACES ? NaN : heights.low + (number / (PLACES - 1)) * (heights.high - heights.low);
        return p;
      };
      for (let j = 0; j + 1 < nv; j++) {
        for (let i = 0; i + 1 < nu; i++) {
          const corners = [place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)];
          if (!corners.every((p) => this.near(p, up))) continue;
          this.pieces.push({ corners, light: this.light(corners, up, heights.spacing) });
        }
      }
      return this.pieces;
    }

    // Faces of bodies that move, where they are now: corners, and how light they are.
    shells(up) {
      const faces = [], [a, b] = [0, 1, 2].filter((c) => c !== up);
      for (const one of this.data.ground.shells) {
        const [at, turned] = one.poses[this.now];
        const placed = one.corners.map((p) => at.map((x, i) => x + turned[i].reduce((sum, r, j) => sum + r * p[j], 0)));
        for (const face of one.faces) {
          const corners = face.map((k) => placed[k]);
          if (!corners.every((p) => this.near(p, up))) continue;
          const [s, t] = [0, 1].map((k) => corners[k + 2].map((x, c) => x - corners[k][c]));
          const normal = s.map((_, c) => s[(c + 1) % 3] * t[(c + 2) % 3] - s[(c + 2) % 3] * t[(c + 1) % 3]);
          faces.push({ corners, light: this.lit(normal[a], normal[b], normal[up]) });
        }
      }
      return faces;
    }

    // How light a piece of a surface is that faces upwards.
    light(corners, up, spacing) {
      const slope = [1, 3].map((k, c) => (corners[k][up] - corners[0][up]) / spacing[c]);
      return this.lit(-slope[0], -slope[1], 1);
    }

    // How light a piece of a surface is by its normal, under light from above the far left corner.
    lit(a, b, up) {
      const light = (-0.45 * a + 0.45 * b + 0.77 * up) / (Math.hypot(a, b, up) || 1);
      return Math.max(0, Math.min(0.75, 0.7 * light));
    }

    // The surface of a flow in pieces as wide as its nodes: corners, how light they are, and the value of the nearest node.
    sheet(frame, v, up) {
      const [a, b] = [0, 1, 2].filter((c) => c !== up), sheet = new Map();
      let pitch = 0;
      for (let k = 0; k < frame.n; k++) pitch += Math.max(frame.w[3 * k + a], frame.w[3 * k + b]) / frame.n;
      if (!(pitch > 0)) return [];
      const reach = 2.5 * pitch, span = (x) => [Math.ceil((x - reach) / pitch), Math.floor((x + reach) / pitch)];
      for (let k = 0; k < frame.n; k++) {
        const x = frame.x[3 * k + a], y = frame.x[3 * k + b], top = frame.x[3 * k + up] + frame.w[3 * k + up] / 2;
        const [left, right] = span(x), [near, far] = span(y);
        for (let i = left; i <= right; i++) {
          for (let j = near; j <= far; j++) {
            const share = 1 - ((i * pitch - x) ** 2 + (j * pitch - y) ** 2) / (reach * reach);
            if (share <= 0) continue;
            const key = i + "," + j, weight = share * share, at = sheet.get(key) || { i, j, sum: 0, top: 0, most: 0, value: 0 };
            at.sum += weight;
            at.top += weight * top;
            if (weight > at.most) [at.most, at.value] = [weight, v[k]];
            sheet.set(key, at);
          }
        }
      }
      const place = (at) => {
        const p = [0, 0, 0];
        [p[a], p[b], p[up]] = [at.i * pitch, at.j * pitch, at.top / at.sum];
        return p;
      };
      const pieces = [];
      for (const at of sheet.values()) {
        const ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([i, j]) => sheet.get(at.i + i + "," + (at.j + j)));
        // A place that only the rim of a node reaches is outside.
        if (!ring.every((one) => one && one.most > 0.3)) continue;
        const corners = ring.map(place);
        pieces.push({ corners, light: this.light(corners, up, [pitch, pitch]), value: at.value });
      }
      return pieces;
    }

    // Behind what stands on it, the ground is drawn by its corners.
    piece(pen, corners, light, colour) {
      pen.fillStyle = css(colour, light);
      pen.strokeStyle = pen.fillStyle;
      pen.beginPath();
      for (const [x, y] of corners) pen.lineTo(x, y);
      pen.closePath();
      pen.fill();
      pen.stroke();
    }

    paint3(canvas, frame, shape) {
      const height = Math.min(440, Math.max(220, 0.75 * canvas.parentElement.clientWidth));
      const [pen, width] = this.pen(canvas, height), camera = this.camera(width, height), v = frame.v[this.field];
      this.box(pen, camera);
      const dots = [], pieces = this.ground();
      for (const { corners, light } of pieces) {
        const seen = corners.map((p) => camera.project(p));
        // A piece lies behind what lies on it.
        dots.push([0, 0, Math.max(...seen.map((p) => p[2])), 0, { seen, light, colour: [125, 105, 80] }]);
      }
      const sheet = shape === "depth" ? this.sheet(frame, v, camera.up) : [];
      const between = (corners, light, colour) => {
        const seen = corners.map((p) => camera.project(p)), away = seen.reduce((sum, p) => sum + p[2] / 4, 0);
        dots.push([0, 0, away, 0, { seen, light, colour }]);
      };
      for (const { corners, light } of this.shells(camera.up)) between(corners, light, [110, 118, 128]);
      for (const { corners, light, value } of sheet) between(corners, light / 2, this.colours[value]);
      for (let k = 0; k < frame.n; k++) {
        const p = [frame.x[3 * k], frame.x[3 * k + 1], frame.x[3 * k + 2]];
        const w = [frame.w[3 * k], frame.w[3 * k + 1], frame.w[3 * k + 2]];
        let across = Math.max(...w);
        if (shape === "depth") {
          across = Math.max(...w.filter((_, c) => c !== camera.up));
          const bed = p.slice();
          bed[camera.up] -= w[camera.up] / 2;
          if (!pieces.length) dots.push([...camera.project(bed), across, null]);
          // Where nodes are too few for a surface each is a dot.
          if (sheet.length) continue;
          p[camera.up] += w[camera.up] / 2;
        }
        dots.push([...camera.project(p), across, v[k]]);
      }
      dots.sort((a, b) => b[2] - a[2]);
      for (const [x, y, away, across, value] of dots) {
        if (value !== null && value.seen) { this.piece(pen, value.seen, value.light, value.colour); continue; }
        const half = Math.max(0.8, camera.scale * across / 2), light = Math.max(0, Math.min(0.45, 0.22 + 0.5 * away));
        const colour = value === null ? [205, 195, 180] : this.colours[value];
        pen.fillStyle = css(colour, light);
        if (half < 2) { pen.fillRect(x - half, y - half, 2 * half, 2 * half); continue; }
        pen.beginPath();
        pen.arc(x, y, half, 0, 7);
        pen.fill();
        if (shape === "disk" || half > 4) {
          pen.fillStyle = css(colour, Math.min(0.75, light + 0.3));
          pen.beginPath();
          pen.arc(x - 0.3 * half, y - 0.3 * half, 0.4 * half, 0, 7);
          pen.fill();
        }
      }
      this.ends(pen, camera);
    }

    // The edges of what the points cover.
    box(pen, camera) {
      const { low, high } = this.data, corner = (bits) => low.map((l, c) => (bits >> c) & 1 ? high[c] : l);
      pen.strokeStyle = LINE;
      for (let bits = 0; bits < 8; bits++) {
        for (let c = 0; c < 3; c++) {
          if ((bits >> c) & 1) continue;
          const [a, b] = [camera.project(corner(bits)), camera.project(corner(bits | (1 << c)))];
          pen.beginPath();
          pen.moveTo(a[0], a[1]);
          pen.lineTo(b[0], b[1]);
          pen.stroke();
        }
      }
    }

    // Ends of three of the edges, over the points.
    ends(pen, camera) {
      const { low, high, axes } = this.data;
      pen.fillStyle = INK;
      pen.textAlign = "center";
      // Beside the box, away from its middle.
      const [cx, cy] = camera.project(low.map((at, c) => (at + high[c]) / 2));
      const write = (text, [x, y], away) => {
        const far = Math.hypot(x - cx, y - cy) || 1;
        // On narrow pages no label leaves the canvas.
        const half = pen.measureText(text).width / 2 + 2;
        const at = Math.min(Math.max(x + ((x - cx) / far) * away, half), pen.canvas.clientWidth - half);
        pen.fillText(text, at, y + ((y - cy) / far) * away + 4);
      };
      for (let c = 0; c < 3; c++) {
        const end = low.slice();
        end[c] = high[c];
        const [from, to] = [camera.project(low), camera.project(end)];
        const long = Math.hypot(to[0] - from[0], to[1] - from[1]);
        for (const [at, text] of ticks(low[c], high[c], Math.max(1, Math.min(3, long / 70)))) {
          if (c > 0 && at - low[c] < 0.1 * (high[c] - low[c])) continue;
          const p = low.slice();
          p[c] = at;
          write(text, camera.project(p), 16);
        }
        const middle = low.slice();
        middle[c] = (low[c] + high[c]) / 2;
        write(axes[c] + " (m)", camera.project(middle), 46);
      }
    }

    // What the colours mean.
    scale() {
      const field = this.data.fields[this.field], [pen, width] = this.pen(this.legend, field.classes ? 26 : 50);
      pen.fillStyle = INK;
      pen.textAlign = "left";
      if (field.classes) {
        let x = 4;
        field.classes.forEach((name, k) => {
          pen.fillStyle = css(this.colours[k]);
          pen.fillRect(x, 6, 13, 13);
          pen.fillStyle = INK;
          pen.fillText(name, x + 18, 17);
          x += 34 + pen.measureText(name).width;
        });
        return;
      }
      pen.fillText(field.name + (field.unit ? " (" + field.unit + ")" : ""), 18, 13);
      const left = 18, room = width - 42;
      for (let k = 0; k < 128; k++) {
        pen.fillStyle = css(mix(this.data.colours, k / 127));
        pen.fillRect(left + (k / 128) * room, 18, room / 128 + 1, 12);
      }
      pen.fillStyle = SOFT;
      pen.textAlign = "center";
      for (const [at, text] of ticks(field.low, field.high, Math.max(2, room / 90))) {
        const x = left + ((at - field.low) / (field.high - field.low)) * room;
        pen.fillRect(x - 0.5, 30, 1, 4);
        pen.fillText(text, x, 46);
      }
    }
  }

  function start() {
    document.querySelectorAll(".player").forEach((root) => { root.player = new Player(root); });
  }
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", start);
  else start();
})();
