"use strict";
// The page of `lorentz explore`. Parts: curves from the tables, particles, plots, data, the page.
// Lengths are in d, speeds in U, times in d/U, densities in 1/d^2, fields in U^2/d.
(() => {
const DATA = JSON.parse(document.getElementById("tables").textContent);
const byId = (name) => document.getElementById(name);
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
const SOLVED = ["dilute", "hard disks"], SHOWN = { dilute: "dilute disks", "hard disks": "hard disks" };

// -- curves from the tables: as kinetics/crosscheck/explore.py reads them ------------------

function chebyshev(x, low, high, count) {
  const u = clamp((2 * x - low - high) / (high - low), -1, 1), found = [1, u];
  for (let k = 2; k < count; k++) found[k] = 2 * u * found[k - 1] - found[k - 2];
  return found;
}

function contracted(c, start, weights, size, count) {
  const found = new Float64Array(size);
  for (let k = 0; k < count; k++)
    for (let j = 0; j < size; j++) found[j] += weights[k] * c[start + k * size + j];
  return found;
}

// A number, or a function of the last variable, at e and perhaps at y, the root of the density.
function lookUp(name, e, y) {
  const t = DATA.tables[name], x = 0.5 - Math.sin(Math.asin(1 - 2 * e) / 3);
  let panel = 0;
  while (panel < t.breaks.length - 2 && x > t.breaks[panel + 1]) panel++;
  const [, nodes, ...rest] = t.shape;
  let size = rest.reduce((a, b) => a * b, 1), ends = t.ends;
  const weights = chebyshev(x, t.breaks[panel], t.breaks[panel + 1], nodes);
  let c = contracted(t.coefficients, panel * nodes * size, weights, size, nodes);
  if (y !== undefined) {
    size /= rest[0];
    c = contracted(c, 0, chebyshev(y, ...ends[0], rest[0]), size, rest[0]);
    ends = ends.slice(1);
  }
  if (!ends.length) return c[0] * DATA.unit;
  const [low, high] = ends[0];
  return (s) => {
    const u = clamp((2 * s - low - high) / (high - low), -1, 1);
    let a = 0, b = 0;
    for (let k = c.length - 1; k > 0; k--) [a, b] = [2 * u * a - b + c[k], a];
    return (u * a - b + c[0]) * DATA.unit;
  };
}

// At e = 1 speeds stay as they start: there is no F(c), and no a2 of it.
// Averages over one collision of smooth disks, and what follows from them among dilute ones.
function lawOf(e) {
  if (e === 1) return { h: 0, turn: 4 / 3, a2: NaN, slope: Infinity, A: 4 / 3 };
  const b = Math.sqrt(1 - e * e), q = e > 0 ? (e * e * Math.atanh(b)) / b : 0;
  const kappa = 1 - (e * Math.acos(e)) / b, s1 = (1 + q) / 2, s3 = (1 + 3 * e * e * s1) / 4;
  const turn = 1 + (e > 0 ? q / e : 0) - (1 - q) / (2 * (1 - e));
  const h = 2 * Math.sqrt(kappa * (1 - s1));
  const a2 = (3 * kappa * (1 - s1)) / (((2 / 3) * (1 - e * e)) * (1 - s3)) - 1;
  return { h, turn, a2, slope: 2 / (kappa * turn), A: (2 * kappa * turn) / h };
}

// v0 in U and <r^2> in l^2 of tracers that keep to the mean, over the Gaussian start; t in l/U.
function factors(h, a, t) {
  let v2 = 0, r2 = 0;
  DATA.speeds.forEach((v, k) => {
    const loss = (h * v * t) / 2, x = a * v * t * (loss > 1e-9 ? Math.log1p(loss) / loss : 1);
    const spread = x > 1e-3 ? 2 * (x + Math.expm1(-x)) : x * x * (1 - x / 3 + (x * x) / 12);
    v2 += DATA.weights[k] * (v / (1 + loss)) ** 2;
    r2 += (DATA.weights[k] * spread) / (a * a);
  });
  return [Math.sqrt(v2), r2];
}

// The exact curves of one e, density and medium.
function curvesOf(e, n, medium) {
  const hard = medium === SOLVED[1], y = hard ? Math.sqrt(n) : undefined, l = 1 / (2 * n);
  const law = lawOf(e), name = (what) => (hard ? "hard " + what : what);
  const h = hard ? lookUp("hard H", e, y) * (1 - e) : law.h;
  const a = hard ? lookUp("hard A", e, y) : law.A;
  const v0 = lookUp(name("v0"), e, y), msd = lookUp(name("msd"), e, y);
  const width = Math.sqrt((1 - e * e) / 5), logF = lookUp(name("ln F"), e, y);
  const averages = (t) => {
    const tau = t / l, [v, r2] = factors(h, a, tau), s = Math.log(tau);
    return [v * v0(s), r2 * msd(s) * l * l];
  };
  return {
    h, averages, v0: (t) => averages(t)[0], msd: (t) => averages(t)[1],
    slope: h > 0 ? (4 / (h * a)) * l * l : Infinity,
    // F(c); NaN where the table does not reach
    F: (c) => {
      const xi = Math.log(c) / width, [low, high] = DATA.widths[medium];
      if (!(width > 0) || xi < low || xi > high) return NaN;
      return Math.exp(logF(xi)) / (2 * Math.PI * width * c * c);
    },
  };
}

// The steady state of what drives the tracer, l = 1 and g, w or D_v = 1; null: there is none.
function steadyOf(drive, e) {
  const powers = DATA.powers[drive];
  if (!powers || e > DATA.highestDriven + 1e-9) return null;
  return Object.fromEntries(Object.entries(powers).map(([name, p]) => [name, lookUp(`${drive} ${name}`, e) * (1 - e) ** p]));
}

// -- particles: tracers among hard disks that are placed at random in a periodic box --------------

function randomOf(seed) {
  let a = seed >>> 0;
  return () => {
    a = (a + 0x6d2b79f5) | 0;
    let t = Math.imul(a ^ (a >>> 15), 1 | a);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

class Gas {
  constructor({ e, n, g = 0, seed = 1, count = 200, disks = 900, trail = 400 }) {
    Object.assign(this, { e, n, g, count, longest: trail, t: 0, k: 0, trail: [], records: [] });
    this.side = Math.sqrt(disks / n);
    this.m = Math.floor(this.side / 1.5);
    this.cell = this.side / this.m;
    this.lists = Array.from({ length: this.m * this.m }, () => []);
    this.cx = [];
    this.cy = [];
    const random = randomOf(seed), anywhere = () => this.side * random();
    const free = () => {
      for (;;) {
        const x = anywhere(), y = anywhere();
        if (!this.near(x, y).some((j) => this.away(j, x, y)[2] < 1)) return [x, y];
      }
    };
    for (let j = 0; j < disks; j++) this.place(j, ...free());
    const make = () => new Float64Array(count);
    for (const name of ["x", "y", "rx", "ry", "vx", "vy"]) this[name] = make();
    this.last = new Int32Array(count).fill(-1); // the disk that was hit
    this.hits = new Int32Array(count);
    this.stuck = new Uint8Array(count);
    for (let i = 0; i < count; i++) {
      [this.x[i], this.y[i]] = free();
      const size = Math.sqrt(-2 * Math.log(1 - random())), angle = 2 * Math.PI * random();
      this.vx[i] = size * Math.cos(angle);
      this.vy[i] = size * Math.sin(angle);
    }
    // the one that is shown has the speed of the mean, so that it always moves
    const scale = Math.SQRT2 / Math.hypot(this.vx[0], this.vy[0]);
    this.vx[0] *= scale;
    this.vy[0] *= scale;
    this.mark();
  }

  place(j, x, y) { // into each cell that tracers in contact with it may be in
    this.cx[j] = x;
    this.cy[j] = y;
    const at = (z) => Math.floor(z / this.cell), m = this.m;
    for (let a = at(x - 1); a <= at(x + 1); a++)
      for (let b = at(y - 1); b <= at(y + 1); b++)
        this.lists[((a + m) % m) * m + ((b + m) % m)].push(j);
  }

  near(x, y) {
    const m = this.m, a = Math.floor(x / this.cell), b = Math.floor(y / this.cell);
    return this.lists[(((a % m) + m) % m) * m + (((b % m) + m) % m)];
  }

  away(j, x, y) { // from the nearest image of a disk: x, y and the square
    const s = this.side;
    let dx = x - this.cx[j], dy = y - this.cy[j];
    dx -= s * Math.round(dx / s);
    dy -= s * Math.round(dy / s);
    return [dx, dy, dx * dx + dy * dy];
  }

  shift(i, dx, dy) {
    const s = this.side;
    this.rx[i] += dx;
    this.ry[i] += dy;
    this.x[i] = (((this.x[i] + dx) % s) + s) % s;
    this.y[i] = (((this.y[i] + dy) % s) + s) % s;
  }

  speed(i) { return Math.hypot(this.vx[i], this.vy[i]); }

  mark() {
    this.trail.push([this.rx[0], this.ry[0], this.speed(0)]);
    if (this.trail.length > this.longest) this.trail.shift();
  }

  bounce(i, j, share = this.e) { // the rule; `share` of the normal speed comes back
    const [dx, dy, square] = this.away(j, this.x[i], this.y[i]), r = Math.sqrt(square);
    const nx = dx / r, ny = dy / r, normal = this.vx[i] * nx + this.vy[i] * ny;
    this.vx[i] -= (1 + share) * normal * nx;
    this.vy[i] -= (1 + share) * normal * ny;
    this.last[i] = j;
    this.hits[i]++;
    if (i === 0) this.mark();
  }

  // How far until a straight path meets a disk, at most `far`: [distance, disk or -1].
  next(i, far) {
    const v = this.speed(i), ux = this.vx[i] / v, uy = this.vy[i] / v, size = this.cell;
    let s = 0, best = far, disk = -1;
    while (s < best) {
      const x = this.x[i] + ux * s, y = this.y[i] + uy * s;
      for (const j of this.near(x, y)) {
        const [dx, dy, square] = this.away(j, x, y), along = dx * ux + dy * uy;
        if (along >= 0) continue;
        const root = along * along - square + 1;
        if (root <= 0) continue;
        const at = Math.max(0, s - along - Math.sqrt(root));
        if (at < best && !(j === this.last[i] && at < 0.5)) [best, disk] = [at, j];
      }
      const out = (z, u) => u === 0 ? Infinity
        : u > 0 ? ((Math.floor(z / size) + 1) * size - z) / u
          : (z - Math.floor(z / size) * size) / -u;
      s += Math.min(out(x, ux), out(y, uy)) + 1e-9;
    }
    return [best, disk];
  }

  fly(i, dt) {
    for (let left = dt, guard = 0; left > 0 && !this.stuck[i]; guard++) {
      const v = this.speed(i);
      if (guard > 300 || !(v > 1e-200)) { // in a corner of two disks, or at rest
        this.stuck[i] = 1;
        return;
      }
      const [far, disk] = this.next(i, v * left);
      this.shift(i, (this.vx[i] / v) * far, (this.vy[i] / v) * far);
      if (disk < 0) return;
      left -= far / v;
      this.bounce(i, disk);
    }
  }

  fall(i, dt) { // the same in a field along x, in short parabolas
    const g = this.g, most = this.hits[i] + 1e5; // of collisions in this time
    for (let left = dt; left > 1e-12 * dt && !this.stuck[i]; this.stuck[i] = this.hits[i] > most ? 1 : 0) {
      const v = this.speed(i), vx = this.vx[i], vy = this.vy[i];
      const h = Math.min(left, 0.1 / (v + Math.sqrt(g)));
      const met = (time) => {
        const dx = (vx + 0.5 * g * time) * time, x = this.x[i] + dx, y = this.y[i] + vy * time;
        return this.near(x, y).find((j) => {
          const [ax, ay, square] = this.away(j, x, y);
          return square < 1 && ax * (vx + g * time) + ay * vy < 0;
        });
      };
      let disk = met(h), low = 0, high = h;
      for (let k = 0; disk !== undefined && k < 40; k++) {
        const middle = 0.5 * (low + high), other = met(middle);
        if (other === undefined) low = middle;
        else [high, disk] = [middle, other];
      }
      const slides = disk !== undefined && low < 1e-9 * h;
      const time = disk === undefined || slides ? h : low;
      this.shift(i, (vx + 0.5 * g * time) * time, vy * time);
      this.vx[i] += g * time;
      left -= time;
      if (!slides && disk !== undefined) this.bounce(i, disk);
      for (let k = 0; slides && k < 4; k++) // on one disk or two: no normal speed, and out of them
        for (const j of this.near(this.x[i], this.y[i])) {
          const [dx, dy, square] = this.away(j, this.x[i], this.y[i]), r = Math.sqrt(square);
          if (r >= 1) continue;
          this.shift(i, dx / r - dx, dy / r - dy);
          if (dx * this.vx[i] + dy * this.vy[i] < 0) this.bounce(i, j, this.e < 1 ? 0 : 1);
        }
    }
    if (i === 0) this.mark();
  }

  advance(dt) { // all tracers; averages are noted at the times of the plots on the way
    for (let end = this.t + dt; this.t < end; ) {
      const stop = Gas.time(this.k), to = Math.min(end, stop);
      for (let i = 0; i < this.count; i++) this.g > 0 ? this.fall(i, to - this.t) : this.fly(i, to - this.t);
      this.t = to;
      if (to === stop) this.note();
    }
  }

  static time(k) { return 0.1 * 10 ** (k / 8); }

  note() {
    const sums = new Float64Array(10), speeds = [];
    for (let i = 1; i < this.count; i++) {
      const v2 = this.vx[i] ** 2 + this.vy[i] ** 2, r2 = this.rx[i] ** 2 + this.ry[i] ** 2;
      [v2, v2 * v2, r2, r2 * r2, this.vx[i], this.vx[i] ** 2, this.rx[i], this.rx[i] ** 2, this.ry[i],
        this.ry[i] ** 2].forEach((value, k) => { sums[k] += value; });
      speeds.push(Math.sqrt(v2));
    }
    const count = this.count - 1, [v2, v4, r2, r4, vx, vxx, x, xx, y, yy] = sums.map((s) => s / count);
    const error = (second, first) => Math.sqrt(Math.max(0, second - first * first) / (count - 1));
    const v0 = Math.sqrt(v2), spread = Math.sqrt(2 / count);
    this.records.push({
      t: this.t, v0: [v0, error(v4, v2) / (2 * v0)], msd: [r2, error(r4, r2)], vx: [vx, error(vxx, vx)],
      xx: [xx - x * x, (xx - x * x) * spread], yy: [yy - y * y, (yy - y * y) * spread],
      scaled: speeds.map((v) => v / v0),
    });
    this.k++;
  }

  step() { // to the next collision of the tracer that is shown
    const before = this.hits[0];
    for (let k = 0; k < 3000 && this.hits[0] === before && !this.stuck[0]; k++) {
      const v = this.speed(0);
      this.advance(this.g > 0 ? 0.05 / (v + Math.sqrt(0.05 * this.g)) : this.next(0, 1e4)[0] / v + 1e-9);
    }
  }
}

// -- plots ----------------------------------------------------------------------------------------

const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const power = (k) => "10" + (k < 0 ? "⁻" : "") + [...String(Math.abs(k))].map((d) => SUPERSCRIPT[d]).join("");
function written(x, digits = 3) {
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "–";
  if (x !== 0 && (Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5)) {
    const k = Math.floor(Math.log10(Math.abs(x)) + 1e-9);
    return `${(x / 10 ** k).toPrecision(digits)}·${power(k)}`;
  }
  const text = x.toPrecision(digits);
  return (text.includes("e") ? String(Number(text)) : text).replace("-", "−");
}

function ticksOf({ log, low, high }, room) {
  if (log && high / low > 12) {
    const from = Math.floor(Math.log10(low)), to = Math.floor(Math.log10(high) + 1e-9);
    const every = Math.ceil((to - from) / room), found = [], few = high / low < 200;
    for (let k = to; k >= from; k -= every)
      for (const z of (few ? [1, 2, 5] : [1]).map((f) => f * 10 ** k))
        found.push([z, few ? number(z) : k === 0 ? "1" : power(k)]);
    return found.filter(([z]) => z >= low * 0.999 && z <= high * 1.001);
  }
  const raw = (high - low) / room, base = 10 ** Math.floor(Math.log10(raw));
  const step = base * [1, 2, 5, 10].find((f) => f * base >= raw * 0.999), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9); k++)
    found.push([k * step, String(Number((k * step).toPrecision(6))).replace("-", "−")]);
  return found;
}

// One plot: axes, curves {f or points, kind}, points {x, y, error, kind}; a marker, a cursor.
class Plot {
  constructor(name) {
    this.figure = byId(name);
    this.svg = this.figure.querySelector("svg");
    this.caption = this.figure.querySelector("figcaption");
    this.readout = this.figure.querySelector("output");
    const moved = (event) => {
      if (event.type === "pointerdown") this.svg.setPointerCapture(event.pointerId);
      const box = this.svg.getBoundingClientRect();
      const x = this.back((event.clientX - box.left) * (this.width / box.width));
      if (this.spec && this.spec.pointed) this.spec.pointed(x, event.buttons > 0);
    };
    this.svg.addEventListener("pointerdown", moved);
    this.svg.addEventListener("pointermove", moved);
    this.svg.addEventListener("pointerleave", () => pointAt(null));
  }

  back(px) {
    const { x } = this.spec, u = clamp((px - this.left) / (this.right - this.left), 0, 1);
    return x.log ? x.low * (x.high / x.low) ** u : x.low + u * (x.high - x.low);
  }

  draw(spec) {
    this.spec = spec;
    this.width = Math.max(260, this.svg.clientWidth || 360);
    this.height = 230;
    [this.left, this.right, this.top, this.bottom] = [54, this.width - 12, 10, this.height - 40];
    const scale = (axis, a, b) => {
      const f = axis.log ? Math.log : (z) => z, low = f(axis.low), high = f(axis.high);
      return (z) => a + ((f(z) - low) / (high - low)) * (b - a);
    };
    const X = (this.X = scale(spec.x, this.left, this.right)), Y = scale(spec.y, this.bottom, this.top);
    const parts = [], { left, right, top, bottom } = this;
    for (const [value, text] of ticksOf(spec.x, Math.floor((right - left) / 55)))
      parts.push(`<path class="grid" d="M${X(value)} ${top}V${bottom}"/><text class="x" x="${X(value)}" y="${bottom + 15}">${text}</text>`);
    for (const [value, text] of ticksOf(spec.y, 5))
      parts.push(`<path class="grid" d="M${left} ${Y(value)}H${right}"/><text class="y" x="${left - 6}" y="${Y(value) + 4}">${text}</text>`);
    parts.push(`<text class="x name" x="${(left + right) / 2}" y="${this.height - 6}">${spec.x.name}</text>`);
    parts.push(`<text class="x name" transform="translate(13 ${(top + bottom) / 2}) rotate(-90)">${spec.y.name}</text>`);
    const inside = (y) => Number.isFinite(y) && !(spec.y.log && y <= 0);
    for (const { f, from = spec.x.low, to = spec.x.high, kind } of spec.curves) {
      let path = "";
      for (let k = 0, pen = "M"; k <= 140; k++) {
        const u = k / 140, x = spec.x.log ? from * (to / from) ** u : from + u * (to - from), y = f(x);
        if (!inside(y)) { pen = "M"; continue; }
        path += `${pen}${X(x).toFixed(1)} ${clamp(Y(y), -999, 1999).toFixed(1)}`;
        pen = "L";
      }
      parts.push(`<path class="curve ${kind}" clip-path="url(#clip-${this.figure.id})" d="${path}"/>`);
    }
    parts.push(`<g class="points" clip-path="url(#clip-${this.figure.id})"></g><path class="frame" d="M${left} ${top}V${bottom}H${right}"/><path class="cursor" d=""/>`);
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.svg.innerHTML = `<title>${spec.title}</title><clipPath id="clip-${this.figure.id}"><rect x="${left}" y="${top - 4}" width="${right - left + 4}" height="${bottom - top + 4}"/></clipPath>${parts.join("")}`;
    this.caption.firstElementChild.innerHTML = spec.title;
    this.caption.lastElementChild.innerHTML = spec.words;
    this.Y = Y;
    this.points();
  }

  points() {
    const { X, Y, spec } = this, { low, high } = spec.x;
    this.svg.querySelector(".points").innerHTML = spec.points().filter(({ x, y }) =>
      x >= low * 0.999 && x <= high * 1.001 && Number.isFinite(y) && !(spec.y.log && y <= 0)
    ).map(({ x, y, error = 0, kind }) => {
      const a = X(x).toFixed(1), up = Y(y + error), down = Y(spec.y.log ? Math.max(y - error, y * 1e-3) : y - error);
      const bar = error > 0 ? `<path class="bar ${kind}" d="M${a} ${up.toFixed(1)}V${down.toFixed(1)}"/>` : "";
      return `${bar}<circle class="${kind}" cx="${a}" cy="${Y(y).toFixed(1)}" r="${kind === "marker" ? 6 : 3}"/>`;
    }).join("");
  }

  cursor(x, text) {
    const shown = x !== null && x >= this.spec.x.low && x <= this.spec.x.high;
    this.svg.querySelector(".cursor").setAttribute("d", shown ? `M${this.X(x)} ${this.top}V${this.bottom}` : "");
    this.readout.textContent = shown ? text : "";
  }
}

// The range of values that are finite and positive, with some room.
function rangeOf(values, log, room = 0.06) {
  const good = values.filter((y) => Number.isFinite(y) && (!log || y > 0));
  let low = Math.min(...good), high = Math.max(...good);
  if (log) return { low: low / 1.4, high: high * 1.4 };
  const more = (high - low || 1) * room;
  return { low: low - more, high: high + more };
}

// -- data that are dropped ------------------------------------------------------------------------

// Names of columns, as `lorentz compare` takes them.
const COLUMNS = {
  time: ["time", "t", "times"], v0: ["thermal_speed", "v0", "v_0", "v0(t)"],
  v2: ["mean_square_speed", "v2", "<v2>", "<v^2>", "msv"],
  msd: ["msd", "r2", "<r2>", "<r^2>", "mean_square_displacement"],
  x: ["x", "xu", "r_x", "rx", "pos_x", "dx"], y: ["y", "yu", "r_y", "ry", "pos_y", "dy"],
  vx: ["vx", "v_x", "vel_x", "velo_x"], vy: ["vy", "v_y", "vel_y", "velo_y"],
  tracer: ["tracer", "id", "particle", "atom", "tracer_id", "particle_id"],
  medium: ["medium", "configuration", "config", "replica", "realisation", "realization", "sample"],
};

// [{t, v0, msd}], one for each time. Throws an Error that says what is missing.
function averagesOf(text) {
  const lines = text.split(/\r?\n/).filter((line) => line.trim() && !line.trim().startsWith("#"));
  if (lines.length < 2) throw new Error("the file has no rows below its head");
  const cut = (line) => line.split(/[,;\t]/).map((cell) => cell.trim().replace(/^"|"$/g, ""));
  const heads = cut(lines[0]).map((name) => name.toLowerCase().replace(/\s*[[(](d|u|d\/u|d\^2|d²|u\^2)[\])]$/, ""));
  const at = Object.fromEntries(Object.entries(COLUMNS).map(([ours, names]) =>
    [ours, heads.findIndex((name) => names.includes(name))]));
  const has = (name) => at[name] >= 0;
  const summed = ["v0", "v2", "msd"].some(has), tracks = has("x") && has("y");
  if (!has("time") || !(summed || tracks))
    throw new Error(`columns are ${heads.join(", ")}; needed are t and v0 or msd, or t, x and y (vx, vy)`);
  const times = new Map();
  lines.slice(1).forEach((line, k) => {
    const cells = cut(line), row = (name) => has(name) ? Number(cells[at[name]] || NaN) : NaN, t = row("time");
    if (!(t >= 0 && t < Infinity)) throw new Error(`row ${k + 2}: the time must be a number, not negative`);
    if (!times.has(t)) times.set(t, []);
    times.get(t).push([row, ["medium", "tracer"].map((name) => cells[at[name]]).join("/")]);
  });
  const start = new Map(); // positions at time 0, of each tracer or of the k-th row
  (times.get(0) || []).forEach(([row, name], k) => start.set(has("tracer") ? name : k, [row("x"), row("y")]));
  const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;
  const found = [...times].sort((a, b) => a[0] - b[0]).map(([t, all]) => {
    if (summed) {
      const [row] = all[0], v0 = has("v0") ? row("v0") : Math.sqrt(row("v2"));
      return { t, v0, msd: row("msd") };
    }
    const r2 = all.map(([row, name], k) => {
      const [x, y] = start.get(has("tracer") ? name : k) || [0, 0];
      return (row("x") - x) ** 2 + (row("y") - y) ** 2;
    });
    return { t, v0: Math.sqrt(mean(all.map(([row]) => row("vx") ** 2 + row("vy") ** 2))), msd: mean(r2) };
  });
  if (found.length > 2000) throw new Error(`${found.length} different times; at most 2000 are read here`);
  return found;
}

// The e whose curves are nearest to the averages, each with the same relative weight.
function fitted(data, n, medium) {
  const off = (e) => {
    const curves = curvesOf(e, n, medium);
    let sum = 0, count = 0;
    for (const { t, v0, msd } of data) {
      if (!(t > 0)) continue;
      const [v, r2] = curves.averages(t);
      for (const [mine, theirs] of [[v, v0], [Math.sqrt(r2), Math.sqrt(msd)]])
        if (theirs > 0) { sum += Math.log(theirs / mine) ** 2; count++; }
    }
    return count ? Math.sqrt(sum / count) : NaN;
  };
  let best = 0;
  for (let k = 1; k <= 100; k++) if (off(k / 100) < off(best)) best = k / 100;
  let low = Math.max(0, best - 0.01), high = Math.min(1, best + 0.01);
  while (high - low > 1e-5) {
    const a = low + 0.382 * (high - low), b = high - 0.382 * (high - low);
    if (off(a) < off(b)) high = b; else low = a;
  }
  const e = (low + high) / 2;
  return { e, deviation: off(e) };
}

// -- the page: its state, which the address holds -------------------------------------------------

const INPUTS = { e: [0.7, 0, 1], n: [0.04, ...DATA.densities], g: [0, 0, 0.1] };
const LAST = 1e5; // the time at which the particles end
// the steady speeds of tracers that are driven without a direction: their unit, and how Python says it
const DRIVEN = {
  bath: { unit: "U", asked: "bath_speed=1.0", words: "Bath: infinitely heavy scatterers that move, each velocity component with the standard deviation U." },
  noise: { unit: "∛(Dᵥl)", asked: "heating=1.0", words: "White noise, ⟨dvᵢdvⱼ⟩ = 2Dᵥδᵢⱼdt." },
};
const DRIVES = ["nothing", ...Object.keys(DATA.powers)];
const state = { medium: SOLVED[0], drive: DRIVES[0], playing: false, data: null, fit: null, curves: {} };
let gas = null, seed = 1;

function readAddress() {
  const told = new URLSearchParams(location.hash.slice(1));
  for (const [name, [value, low, high]] of Object.entries(INPUTS)) {
    const given = Number.parseFloat(told.get(name));
    state[name] = Number.isFinite(given) ? clamp(given, low, high) : value;
  }
  state.medium = SOLVED[told.get("medium") === "hard-disks" ? 1 : 0];
  state.drive = state.g > 0 ? "field" : told.get("drive") in DRIVEN ? told.get("drive") : DRIVES[0];
}

const number = (x) => String(Number(x.toPrecision(6)));
function writeAddress() {
  const { e, n, g, medium, drive } = state, more = drive in DRIVEN ? `&drive=${drive}` : "";
  const hash = `#e=${number(e)}&n=${number(n)}&g=${number(g)}&medium=${medium.replace(" ", "-")}${more}`;
  try { history.replaceState(null, "", hash); } catch { location.replace(hash); }
}

// Anything that the hand changes comes here; particles begin again where their system changes.
function change(values, again = true) {
  Object.assign(state, values);
  if ("drive" in values) state.g = state.drive === "field" ? state.g || 0.02 : 0;
  else if ("g" in values) state.drive = state.g > 0 ? "field" : state.drive === "field" ? DRIVES[0] : state.drive;
  const { e, n, g, drive } = state, driven = drive !== DRIVES[0];
  if (driven) state.medium = SOLVED[0]; // the theory of driven tracers is that of dilute scatterers
  state.curves = Object.fromEntries(SOLVED.map((medium) => [medium, curvesOf(e, n, medium)]));
  state.steady = steadyOf(drive, e);
  for (const name of Object.keys(INPUTS)) byId(name).value = state[name];
  byId("pace").setAttribute("aria-valuetext", byId("pace-shown").textContent = `× ${2 ** Number(byId("pace").value)}`);
  byId("e-shown").textContent = e.toFixed(3).replace(/0$/, "");
  byId("n-shown").textContent = `${number(n)} d⁻²`;
  byId("g-shown").textContent = `${number(g)} U²/d`;
  for (const medium of SOLVED) {
    const radio = byId("medium-" + medium.replace(" ", "-"));
    radio.checked = state.medium === medium;
    radio.disabled = driven && medium !== SOLVED[0];
  }
  byId("drive").value = drive;
  byId("mass").hidden = drive === "bath"; // no such likeness where scatterers move
  byId("driven").textContent = drive in DRIVEN ? `${DRIVEN[drive].words} The tracers of this page are not driven by it.` : "";
  if (again) restart();
  if (state.data) fitData();
  writeAddress();
  showNumbers();
  byId("code").textContent = codeOf(state);
  drawPlots();
  drawDisks();
}

function restart() {
  const { e, n, g } = state;
  gas = new Gas({ e, n, g, seed: seed++, count: 201 });
  camera.x = camera.y = 0;
}

function showNumbers() {
  const { e, n, g, drive, curves, steady } = state, law = lawOf(e), mass = (1 + e) / (1 - e);
  byId("mass").innerHTML = e === 1
    ? "fixed scatterers, elastic: M/m = ∞"
    : `as elastic bounces from scatterers at rest of mass M/m = <b>${written(mass)}</b>: neutrons, A = ${written(mass)}; ions, m/M = ${written(1 / mass)}`;
  const rows = [
    ["h", "cooling rate, v₀ → 2l/(ht)", written(law.h, 5), written(curves[SOLVED[1]].h, 4)],
    ["a₂", "⟨c⁴⟩/2 − 1 of F(c)", written(law.a2, 4), ""],
    ["d⟨r²⟩/d ln t", "at late times, in d²", written(curves[SOLVED[0]].slope, 4), written(curves[SOLVED[1]].slope, 4)],
    ["l", "1/(2dρ₀), in d", written(1 / (2 * n), 4), ""],
  ];
  const speed = Math.sqrt(g / (2 * n)); // sqrt(g l)
  if (steady && g > 0) rows.splice(0, 3,
    ["⟨vₓ⟩", "steady drift, in U", written(steady.drift * speed, 4), ""],
    ["D∥", "along the field, in dU", written((steady.parallel * speed) / (2 * n), 4), ""],
    ["D⊥", "across it, in dU", written((steady.perpendicular * speed) / (2 * n), 4), ""]);
  else if (drive in DRIVEN) rows.splice(0, 3, ...figuresOf(drive).map(([name, words, unit, f]) =>
    [name, words + (unit && `, in ${unit}`), steady ? written(f(steady), 4) : "–", ""]));
  byId("numbers").innerHTML = rows.map(([name, words, ...values]) =>
    `<tr><th scope="row">${name} <span>${words}</span></th>${values.map((v) => `<td>${v}</td>`).join("")}</tr>`).join("");
}

// The Scene of the sliders.
function codeOf({ e, n, g, medium, drive, steady }) {
  const { asked, unit } = DRIVEN[drive] || {}, also = { field: ", solve_field", nothing: "" }[drive] ?? ", solve_steady";
  const more = g > 0 ? `field=${number(g)}` : asked || `scatterers="${medium}"`;
  const outputs = g > 0 ? '"mean_velocity", "displacement_tensor"' : '"thermal_speed", "msd"';
  return [
    "import numpy as np", `from kinetics import Scene, solve${steady ? also : ""}`, "",
    "scene = Scene(", `    restitution=${number(e)}, number_density=${number(n)},`, `    ${more},`,
    "    times=np.geomspace(0.1, 1e4, 51),", `    outputs=(${outputs}),`, ")",
    "solution = solve(scene)  # in d and U", "print(solution.to_dataframe())",
    ...(steady && g > 0 ? [`steady = solve_field(${number(e)})`, `print(steady.in_units(${number(g)}, 1.0, ${number(n)}).drift)`] : []),
    ...(steady && asked ? [`steady = solve_steady(${number(e)}, ${asked})  # lengths in l, speeds in ${unit}`,
      "print(steady.thermal_speed, steady.diffusion_coefficient, steady.a2)"] : []),
  ].join("\n");
}

async function copyCode() {
  const text = byId("code").textContent;
  let done = true;
  try { await navigator.clipboard.writeText(text); } catch {
    const range = document.createRange();
    range.selectNodeContents(byId("code"));
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    done = document.execCommand("copy");
  }
  say(done ? "Copied." : "Selected: copy it with Ctrl+C.");
}
function say(text) { byId("said").textContent = text; }

// -- what the four plots show ---------------------------------------------------------------------

const plots = {};
let pointed = null; // the time under the pointer

const measured = (name) => () => gas.records.map(({ t, [name]: [y, error] }) => ({ x: t, y, error, kind: "own" }));
const rowsOf = (name) => (state.data || []).map((row) => ({ x: row.t, y: row[name], kind: "data" }));
const moveE = (e, pressed) => { if (pressed) change({ e: Math.round(clamp(e, 0, 1) * 100) / 100 }); };
const overTime = () => {
  const given = (state.data || []).map((row) => row.t), last = Math.max(LAST, ...given);
  const low = Math.min(0.1, ...given.filter((t) => t > 0));
  return { log: true, low: Math.max(low, 1e-3), high: Math.min(last, 1e7), name: "time t in d/U" };
};
// two curves, the medium that is chosen drawn last and bold
const both = (what) => [...SOLVED].sort((a) => (a === state.medium ? 1 : -1)).map((medium) => ({
  f: state.curves[medium][what],
  kind: `${medium === SOLVED[0] ? "dilute" : "hard"} ${medium === state.medium ? "chosen" : ""}`,
}));
const samples = (f, { log, low, high }) =>
  Array.from({ length: 40 }, (_, k) => f(log ? low * (high / low) ** (k / 39) : low + ((high - low) * k) / 39));
const overE = (medium) => (e) => {
  if (e > 0.995) return NaN;
  return medium === SOLVED[0] ? lawOf(e).h / (1 - e) : lookUp("hard H", e, Math.sqrt(state.n));
};

function averagePlot(name, axis, log, title, words) {
  const x = overTime(), curves = both(name);
  const values = curves.flatMap(({ f }) => samples(f, x)).concat(rowsOf(name).map(({ y }) => y));
  return {
    x, curves, title, words, y: log ? { log, ...rangeOf(values, true), name: axis } : { low: 0, high: 1.05 * Math.max(...values.filter(Number.isFinite)), name: axis },
    points: () => [...measured(name)(), ...rowsOf(name)], pointed: pointAt,
    said: (t) => `${SOLVED.map((m) => `${m} ${written(state.curves[m][name](t))}`).join(", ")}`,
  };
}

function plotsOfCooling() {
  const { e, n } = state, hard = lookUp("hard H", e, Math.sqrt(n)), dilute = lawOf(e);
  const rates = [...SOLVED].flatMap((m) => samples(overE(m), { low: 0, high: 0.99 }));
  const ring = e === 1;
  return {
    first: averagePlot("v0", "v₀ in U", true, "Thermal speed v₀(t)", "v₀ = √⟨v²⟩. At late times Haff’s law, v₀ = 2l/(ht)."),
    second: averagePlot("msd", "⟨r²⟩ in d²", e > 0.97, "Mean square displacement ⟨r²⟩(t)", "It grows like ln t without a bound (like t for e = 1)."),
    third: {
      x: { low: 0, high: 3, name: "c = v/v₀" }, y: { log: true, low: 3e-4, high: 8, name: "F(c)" },
      title: "Scaled velocity distribution F(c)",
      words: ring ? "Elastic speeds do not change: the start, dotted, stays. For e → 1 F is a narrow ring at c = 1."
        : "The exact F, of integral 1 over the plane, at late times. Dotted: the Gaussian start. Points: speeds of the last five times.",
      curves: [{ f: (c) => Math.exp(-c * c) / Math.PI, kind: "start" },
        ...both("F").map((curve) => ({ ...curve, from: 0.01 }))],
      points: () => histogram(),
    },
    fourth: {
      x: { low: 0, high: 1, name: "restitution e" },
      y: { ...rangeOf([...rates, 1.45], false), name: "h/(1 − e)" },
      title: "Cooling rate h(e) over 1 − e",
      words: "Drag to change e. Dotted: 1.45, from the paper’s simulation.",
      curves: [{ f: () => 1.45, kind: "start" }, ...both("h").map((curve) => ({ ...curve, f: overE(curve.kind.startsWith("dilute") ? SOLVED[0] : SOLVED[1]), to: 0.995 }))],
      points: () => [{ x: e, y: state.medium === SOLVED[1] ? hard : e === 1 ? 4 / 3 : dilute.h / (1 - e), kind: "marker" }],
      pointed: moveE,
    },
  };
}

const OVER_E = { low: 0, high: 0.98 };
const steadyCurve = (drive) => (f) => (e) => { const found = steadyOf(drive, e); return found ? f(found) : NaN; };

// Of a bath or noise: sign, words, unit, value, range of the plot (or whether it has a log scale).
const figuresOf = (drive, unit = DRIVEN[drive].unit) => [
  ["v₀", "thermal speed √⟨v²⟩", unit, (z) => z.v0, true],
  ["D", "diffusion coefficient", unit === "U" ? "lU" : `l${unit}`, (z) => z.D, true],
  ["a₂", "⟨v⁴⟩/(2v₀⁴) − 1, 0 for a Gaussian", "", (z) => z.fourth - 1, { low: -0.2, high: 0.3 }],
  ["D/(μ⟨vₓ²⟩)", "1 by Einstein’s relation; μ, the mobility", "", (z) => z.einstein, { low: 0.9, high: 1.15 }],
];

function plotsDriven() {
  const { e, drive, steady } = state, at = steadyCurve(drive);
  return Object.fromEntries(figuresOf(drive).map(([name, words, unit, f, range], k) => [Object.keys(plots)[k], {
    x: { low: 0, high: 1, name: "restitution e" }, title: `Steady state: ${name} over e`,
    y: { name: name + (unit && ` in ${unit}`), ...(range === true ? { log: true, ...rangeOf(samples(at(f), OVER_E), true) } : range) },
    words: `${words[0].toUpperCase()}${words.slice(1)}. ${steady ? "Drag to change e." : `Drawn up to e = ${DATA.highestDriven}; elastic tracers have no steady state.`}`,
    curves: [{ f: at(f), kind: "dilute chosen" }], pointed: moveE,
    points: () => (steady ? [{ x: e, y: f(steady), kind: "marker" }] : []),
  }]));
}

function plotsInField() {
  const { e, n, g, steady } = state, l = 1 / (2 * n), speed = Math.sqrt(g * l), spread = speed * l;
  const none = "No steady state: elastic tracers gain speed for ever.", x = overTime();
  const line = (y) => (steady ? [{ f: () => y, kind: "dilute chosen" }] : []);
  const most = steady ? 2 * steady.drift * speed : 2 * speed;
  const drawn = steady ? [["along", "parallel", "xx", "own"], ["across", "perpendicular", "yy", "own across"]] : [];
  const at = steadyCurve("field");
  const kinds = { parallel: "dilute chosen", perpendicular: "hard chosen" };
  const all = Object.keys(kinds).flatMap((k) => samples(at((z) => z[k]), OVER_E));
  const marker = (...names) => () => (steady ? names.map((name) => ({ x: e, y: steady[name], kind: "marker" })) : []);
  return {
    first: {
      x, y: { low: -0.4 * most, high: most, name: "⟨vₓ⟩ in U" }, title: "Mean velocity along the field",
      words: steady ? "Line: the exact steady drift among dilute disks. Points: own tracers, among hard disks." : none,
      curves: line(steady ? steady.drift * speed : 0), points: measured("vx"), pointed: pointAt,
      said: () => (steady ? `steady drift ${written(steady.drift * speed)} U` : ""),
    },
    second: {
      x, y: { log: true, ...rangeOf(steady ? [0.02, 2 * steady.perpendicular * spread * x.high] : [0.02, 1e6], true), name: "variance in d²" },
      title: "Dispersion over time", words: steady ? "Variance along x (full) and across (dashed), 2Dt at late times." : none,
      curves: drawn.map(([, which]) => ({ f: (t) => 2 * steady[which] * spread * t, kind: kinds[which] })),
      points: () => ["xx", "yy"].flatMap((k) => gas.records.map((r) => ({ x: r.t, y: r[k][0], error: r[k][1], kind: k === "xx" ? "own" : "own across" }))),
      pointed: pointAt,
      said: () => (steady ? `2D is ${written(2 * steady.parallel * spread)} and ${written(2 * steady.perpendicular * spread)} d U` : ""),
    },
    third: {
      x: { low: 0, high: 1, name: "restitution e" }, y: { low: 0, high: 1.05, name: "drift in √(gl)" },
      title: "Drift (percolation velocity) over e", words: "Drag to change e. Open point: mean of the last five times of the own tracers.",
      curves: [{ f: at((z) => z.drift), kind: "dilute chosen" }],
      points: () => [...marker("drift")(), ...lastDrift(speed)], pointed: moveE,
    },
    fourth: {
      x: { low: 0, high: 1, name: "restitution e" }, y: { ...rangeOf([0, ...all], false), name: "D in √(gl³)" },
      title: "Dispersion over e", words: "Half the growth of the variance along (full) and across the field (dashed).",
      curves: Object.entries(kinds).map(([name, kind]) => ({ f: at((z) => z[name]), kind })),
      points: marker("parallel", "perpendicular"), pointed: moveE,
    },
  };
}

function lastDrift(speed) {
  const last = gas.records.slice(-5).map(({ vx: [v] }) => v / speed);
  return last.length < 5 ? [] : [{ x: state.e, y: last.reduce((a, b) => a + b) / 5, kind: "own" }];
}

function histogram() { // F(c) of the own speeds, each bin over its ring
  const speeds = gas.records.slice(-5).flatMap(({ scaled }) => scaled), width = 0.2, bins = new Array(15).fill(0);
  for (const c of speeds) if (c < 3) bins[Math.floor(c / width)]++;
  return bins.map((count, k) => {
    const area = Math.PI * width * width * (2 * k + 1) * speeds.length; // speeds of five times hang together
    return { x: (k + 0.5) * width, y: count / area, error: Math.sqrt(5 * count) / area, kind: "own" };
  });
}

function drawPlots() {
  const specs = state.g > 0 ? plotsInField() : state.drive in DRIVEN ? plotsDriven() : plotsOfCooling();
  for (const [name, spec] of Object.entries(specs)) plots[name].draw(spec);
  byId("legend").hidden = state.drive !== DRIVES[0];
  pointAt(state.drive in DRIVEN ? null : pointed);
}

function pointAt(t) { // one cursor for both plots over time
  pointed = t;
  for (const name of ["first", "second"]) {
    const plot = plots[name];
    if (plot.spec) plot.cursor(t, t === null ? "" : `t = ${written(t)}: ${plot.spec.said(t)}`);
  }
}

// -- the disks ------------------------------------------------------------------------------------

const canvas = byId("disks"), camera = { x: 0, y: 0 };
const SHADES = [[28, 126, 214], [174, 62, 201], [232, 89, 12]]; // slow to fast

function shade(v) { // from 1e-3 to 2 U, in ln v
  const u = clamp((Math.log10(v) + 3) / 3.3, 0, 1) * 2, k = Math.min(1, Math.floor(u));
  return `rgb(${SHADES[k].map((a, j) => Math.round(a + (SHADES[k + 1][j] - a) * (u - k))).join()})`;
}

function drawDisks() {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d"), zoom = width / (9 / Math.sqrt(gas.n));
  const halfX = width / zoom / 2, halfY = height / zoom / 2, x = gas.rx[0], y = gas.ry[0];
  camera.x = clamp(camera.x, x - 0.6 * halfX, x + 0.6 * halfX); // it follows where the tracer leaves
  camera.y = clamp(camera.y, y - 0.6 * halfY, y + 0.6 * halfY);
  const X = (a) => width / 2 + (a - camera.x) * zoom, Y = (b) => height / 2 - (b - camera.y) * zoom;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  const style = getComputedStyle(canvas);
  pen.fillStyle = style.getPropertyValue("--disk");
  const left = gas.x[0] - x + camera.x, low = gas.y[0] - y + camera.y, s = gas.side; // centre, in the box
  gas.cx.forEach((cx, j) => {
    const wrap = (d) => d - s * Math.round(d / s), dx = wrap(cx - left), dy = wrap(gas.cy[j] - low);
    if (Math.abs(dx) > halfX + 1 || Math.abs(dy) > halfY + 1) return;
    pen.beginPath();
    pen.arc(width / 2 + dx * zoom, height / 2 - dy * zoom, 0.5 * zoom, 0, 2 * Math.PI);
    pen.fill();
  });
  const path = [...gas.trail, [x, y, gas.speed(0)]];
  pen.lineWidth = Math.max(1.5, 0.14 * zoom);
  pen.lineCap = "round";
  for (let k = 1; k < path.length; k++) {
    pen.strokeStyle = shade(path[k - 1][2]);
    pen.beginPath();
    pen.moveTo(X(path[k - 1][0]), Y(path[k - 1][1]));
    pen.lineTo(X(path[k][0]), Y(path[k][1]));
    pen.stroke();
  }
  pen.fillStyle = shade(gas.speed(0));
  pen.strokeStyle = style.color;
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.arc(X(x), Y(y), 0.5 * zoom, 0, 2 * Math.PI);
  pen.fill();
  pen.stroke();
  const still = gas.stuck.reduce((a, b) => a + b, 0);
  byId("clock").textContent = `t = ${written(gas.t)} d/U, v = ${written(gas.speed(0))} U, ${gas.hits[0]} collisions`
    + (still ? `; ${still} of ${gas.count} tracers at rest or caught in a corner` : "");
}

let frame = 0;
function play(on) {
  state.playing = on && gas.t < LAST;
  byId("play").textContent = state.playing ? "Pause" : "Play";
  cancelAnimationFrame(frame);
  if (state.playing) frame = requestAnimationFrame(tick);
}

function tick() {
  const pace = 2 ** Number(byId("pace").value), began = performance.now(), before = gas.records.length;
  // by a share of t, as tracers slow down like 1/t, but on the picture never too far
  let left = pace * Math.min(Math.max(0.005 * gas.t, 0.05), 0.3 / Math.max(gas.speed(0), 1e-9));
  left = Math.min(left, 0.2 * gas.t + 1, LAST - gas.t);
  for (; left > 0 && performance.now() - began < 25; left -= 1) gas.advance(Math.min(1, left, LAST - gas.t));
  drawDisks();
  if (gas.records.length !== before) for (const plot of Object.values(plots)) plot.points();
  gas.t < LAST ? (frame = requestAnimationFrame(tick)) : play(false);
}

// -- what the hand does ---------------------------------------------------------------------------

function fitData() {
  if (state.drive !== DRIVES[0]) return say("Data are compared with tracers that nothing drives: set “driven by” to nothing.");
  const { e, deviation } = (state.fit = fitted(state.data, state.n, state.medium));
  byId("fit").hidden = !Number.isFinite(deviation);
  say(Number.isFinite(deviation)
    ? `${state.data.length} times. Nearest among ${SHOWN[state.medium]} of this density: e = ${e.toFixed(3)}, off by ${(100 * deviation).toPrecision(2)} % (rms). For errors and causes, of a file with every tracer: lorentz compare ${state.file}`
    : "No time above 0 with an average above 0.");
}

async function take(file) {
  if (!file) return;
  try {
    const data = averagesOf(await file.text());
    state.file = file.name;
    change({ data }, false);
  } catch (error) { say(`${file.name}: ${error.message}.`); }
}

function begin() {
  for (const name of ["first", "second", "third", "fourth"]) plots[name] = new Plot(name);
  for (const name of Object.keys(INPUTS))
    byId(name).addEventListener("input", (event) => change({ [name]: Number(event.target.value) }));
  byId("pace").addEventListener("input", () => change({}, false));
  for (const medium of SOLVED)
    byId("medium-" + medium.replace(" ", "-")).addEventListener("change", () => change({ medium }, false));
  byId("drive").addEventListener("change", (event) => change({ drive: event.target.value }));
  const step = () => { play(false); gas.step(); drawDisks(); drawPlots(); };
  const actions = { play: () => play(!state.playing), step, restart: () => change({}), copy: copyCode,
    fit: () => change({ e: Number(state.fit.e.toFixed(3)) }) };
  for (const [name, action] of Object.entries(actions)) byId(name).addEventListener("click", action);
  const keys = { " ": "play", s: "step", r: "restart" };
  addEventListener("keydown", (event) => {
    const busy = /^(INPUT|BUTTON|SUMMARY|A|LABEL)$/.test(event.target.tagName) && event.key === " ";
    if (busy || event.ctrlKey || event.metaKey || event.altKey || !(event.key in keys)) return;
    event.preventDefault();
    actions[keys[event.key]]();
  });
  canvas.addEventListener("pointerdown", () => actions.play());
  byId("file").addEventListener("change", (event) => take(event.target.files[0]));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => { event.preventDefault(); take(event.dataTransfer.files[0]); });
  addEventListener("hashchange", () => { readAddress(); change({}); });
  addEventListener("resize", () => { drawPlots(); drawDisks(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawDisks);
  readAddress();
  change({});
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
}

// What tests ask the page.
window.explorer = { curvesOf, lawOf, steadyOf, averagesOf, fitted, codeOf, change, state, play, Gas, gas: () => gas };
begin();
})();
