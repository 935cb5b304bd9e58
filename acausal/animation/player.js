// Plays a scene on a canvas: sprites moved by channels of numbers, in the plane or in space.
// window.animation lets other scripts play, pause, and seek.
"use strict";
(function () {
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const bytes = Uint8Array.from(atob(scene.data), (c) => c.charCodeAt(0));
  const data = new Float32Array(bytes.buffer);
  const n = scene.n, space = scene.dimension === 3, cam = scene.camera;
  const canvas = document.getElementById("view"), ctx = canvas.getContext("2d");
  const $ = (id) => document.getElementById(id);
  const t0 = scene.start, t1 = scene.stop;
  let time = t0, playing = false, looping = true, speed = scene.speed, last = 0, trails = true;
  let width = 1, height = 1, px = 1;
  const fresh = () => ({ zoom: 1, x: 0, y: 0, azimuth: cam.azimuth, elevation: cam.elevation, follow: cam.follow.length > 0 });
  let view = fresh();

  // ---- numbers at a time ------------------------------------------------------------------
  let frame = 0, part = 0;
  function setTime(t) {
    time = Math.min(t1, Math.max(t0, t));
    const at = ((time - t0) / (t1 - t0)) * (n - 1);
    frame = Math.min(n - 2, Math.floor(at));
    part = at - frame;
  }
  function value(ref) {
    if (typeof ref === "number") return ref;
    const k = ref[0] * n + frame;
    return data[k] + (data[k + 1] - data[k]) * part;
  }
  const sample = (ref, k) => (typeof ref === "number" ? ref : data[ref[0] * n + k]);
  const visible = (s) => s.visible === undefined || value(s.visible) > 0.5;

  // ---- canvas -----------------------------------------------------------------------------
  function resize() {
    const box = canvas.parentElement.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    width = Math.max(1, Math.round(box.width * ratio));
    height = Math.max(1, Math.round(box.height * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    px = Math.max(0.7 * ratio, Math.min(width, height) / 600);
  }
  function path(points, closed) {
    ctx.beginPath();
    for (let k = 0; k < points.length; k += 2) {
      if (k) ctx.lineTo(points[k], points[k + 1]); else ctx.moveTo(points[k], points[k + 1]);
    }
    if (closed) ctx.closePath();
  }
  function nice(x) {
    const p = Math.pow(10, Math.floor(Math.log10(x))), m = x / p;
    return (m < 1.5 ? 1 : m < 3.5 ? 2 : m < 7.5 ? 5 : 10) * p;
  }
  function metres(x) {
    const round = (v) => String(parseFloat(v.toPrecision(3)));
    if (x >= 1000) return round(x / 1000) + " km";
    if (x >= 1) return round(x) + " m";
    if (x >= 0.01) return round(x * 100) + " cm";
    return round(x * 1000) + " mm";
  }

  // ---- in the plane -----------------------------------------------------------------------
  let scale = 1, midX = 0, midY = 0;
  function plane() {
    scale = view.zoom * Math.min(width / cam.extent[0], height / cam.extent[1]);
    const followed = cam.follow.length && view.follow;
    midX = (followed ? value(cam.follow[0]) : cam.center[0]) + view.x;
    midY = (followed ? value(cam.follow[1]) : cam.center[1]) + view.y;
    if (cam.follow.length && !followed) scale = view.zoom * Math.min(width / cam.whole[0], height / cam.whole[1]);
    if (scene.grid) grid();
    for (const s of scene.sprites) {
      if (!visible(s)) continue;
      if (s.kind === "placed") placed(s);
      else if (s.kind === "stretched") stretched(s);
      else if (s.kind === "trail") { if (trails) trail(s, (k) => [X(sample(s.c[0], k)), Y(sample(s.c[1], k))]); }
      else if (s.kind === "text") label(s, X(value(s.c[0])), Y(value(s.c[1])));
    }
    ruler();
  }
  const X = (x) => width / 2 + (x - midX) * scale;
  const Y = (y) => height / 2 - (y - midY) * scale;
  function grid() {
    const step = nice((90 * px) / scale);
    for (const [size, mid, along] of [[width, midX, true], [height, midY, false]]) {
      const half = size / 2 / scale;
      for (let k = Math.ceil((mid - half) / step); k * step <= mid + half; k++) {
        const at = along ? X(k * step) : Y(k * step);
        ctx.strokeStyle = k === 0 ? "#c3ccd5" : "#e6eaee";
        ctx.lineWidth = px;
        path(along ? [at, 0, at, height] : [0, at, width, at]);
        ctx.stroke();
      }
    }
  }
  function ruler() {
    const step = nice((90 * px) / scale), x = 16 * px, y = height - 16 * px, w = step * scale;
    ctx.strokeStyle = "#5b6672"; ctx.lineWidth = 1.5 * px;
    path([x, y - 4 * px, x, y, x + w, y, x + w, y - 4 * px]); ctx.stroke();
    ctx.fillStyle = "#5b6672"; ctx.font = 12 * px + "px system-ui, sans-serif"; ctx.textAlign = "center";
    ctx.fillText(metres(step), x + w / 2, y - 6 * px);
  }
  function parts(geometry, place) {
    for (const p of geometry) {
      const size = p.d, m = p.p.length / size, out = new Array(2 * m);
      for (let k = 0; k < m; k++) place(p.p, k * size, out, 2 * k);
      path(out, p.closed);
      if (p.fill) { ctx.fillStyle = p.fill; ctx.fill(); }
      if (p.stroke) {
        ctx.strokeStyle = p.stroke; ctx.lineWidth = Math.abs(p.width) * px;
        if (p.width < 0) ctx.setLineDash([6 * px, 5 * px]);
        ctx.stroke(); ctx.setLineDash([]);
      }
    }
  }
  function placed(s) {
    const x = value(s.c[0]), y = value(s.c[1]), a = value(s.c[2]), c = Math.cos(a), d = Math.sin(a);
    parts(scene.geometries[s.g], (p, k, out, j) => {
      out[j] = X(x + c * p[k] - d * p[k + 1]);
      out[j + 1] = Y(y + d * p[k] + c * p[k + 1]);
    });
  }
  function stretched(s) {
    const ax = value(s.c[0]), ay = value(s.c[1]), bx = value(s.c[2]), by = value(s.c[3]);
    const l = Math.hypot(bx - ax, by - ay), ex = l > 0 ? (bx - ax) / l : 1, ey = l > 0 ? (by - ay) / l : 0;
    parts(scene.geometries[s.g], (p, k, out, j) => {
      const u = p[k] * l + p[k + 1], v = p[k + 2];
      out[j] = X(ax + u * ex - v * ey);
      out[j + 1] = Y(ay + u * ey + v * ex);
    });
  }
  function trail(s, point) {
    const span = s.size > 0 ? Math.ceil((s.size / (t1 - t0)) * (n - 1)) : frame + 1;
    const first = Math.max(0, frame + 1 - span), all = [];
    for (let k = first; k <= frame; k++) all.push(point(k));
    const now = point(frame), next = point(frame + 1);
    all.push([now[0] + (next[0] - now[0]) * part, now[1] + (next[1] - now[1]) * part]);
    const chunks = s.size > 0 ? 12 : 1;
    ctx.lineWidth = 1.8 * px; ctx.strokeStyle = s.color; ctx.lineJoin = "round";
    for (let c = 0; c < chunks; c++) {
      const a = Math.floor((c * (all.length - 1)) / chunks), b = Math.floor(((c + 1) * (all.length - 1)) / chunks);
      if (b <= a) continue;
      ctx.globalAlpha = chunks > 1 ? (0.75 * (c + 1)) / chunks : 0.55;
      path(all.slice(a, b + 1).flat()); ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }
  function label(s, x, y) {
    ctx.fillStyle = s.color; ctx.font = s.size * px + "px system-ui, sans-serif"; ctx.textAlign = "center";
    ctx.fillText(s.text, x, y);
  }

  // ---- in space ---------------------------------------------------------------------------
  let R, U, V, C;                                 // right, up, towards the viewer, centre
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const l = Math.sqrt(dot(a, a)) || 1; return [a[0] / l, a[1] / l, a[2] / l]; };
  const mix = (a, x, b, y, c, z) => [a[0] * x + b[0] * y + c[0] * z, a[1] * x + b[1] * y + c[1] * z, a[2] * x + b[2] * y + c[2] * z];
  const W = cam.up || [0, 0, 1];
  const E1 = unit(cross(Math.abs(W[1]) > 0.9 ? [0, 0, -1] : [0, 1, 0], W)), E2 = cross(W, E1);
  function orient() {
    const a = (view.azimuth * Math.PI) / 180, e = (view.elevation * Math.PI) / 180;
    const ahead = mix(E1, Math.sin(a), E2, -Math.cos(a), W, 0);
    V = mix(ahead, Math.cos(e), W, Math.sin(e), W, 0);
    R = unit(cross(W, ahead)); U = cross(V, R);
    C = cam.follow.length && view.follow ? cam.follow.map(value) : cam.center.slice();
    C = mix(C, 1, R, view.x, U, view.y);
    scale = (view.zoom * Math.min(width, height)) / cam.extent[0] / 0.98;
  }
  function project(p) {
    const d = [p[0] - C[0], p[1] - C[1], p[2] - C[2]], far = 2.6 * cam.extent[0], z = dot(d, V);
    const f = far / Math.max(far - z, 0.05 * far);
    return [width / 2 + dot(d, R) * f * scale, height / 2 - dot(d, U) * f * scale, z, f];
  }
  const LIGHT = unit([-0.4, 0.6, 0.8]);
  function shade(color, light) {
    const c = parseInt(color.slice(1), 16);
    const ch = (v) => Math.round(light <= 1 ? v * light : v + (255 - v) * (light - 1));
    return "rgb(" + ch(c >> 16) + "," + ch((c >> 8) & 255) + "," + ch(c & 255) + ")";
  }
  function floor() {
    const half = 0.75 * cam.extent[0], step = nice(half / 6), m = Math.ceil(half / step);
    const middle = mix(cam.center, 1, W, cam.floor, W, 0);
    const base = (v) => Math.round(dot(middle, v) / step) * step;
    const o = mix(mix(E1, base(E1), E2, base(E2), W, dot(middle, W)), 1, W, 0, W, 0);
    ctx.lineWidth = px;
    for (const [p, q] of [[E1, E2], [E2, E1]]) {
      for (let k = -m; k <= m; k++) {
        ctx.strokeStyle = "rgba(150,163,176," + 0.45 * (1 - Math.abs(k) / (m + 1)) + ")";
        const a = project(mix(o, 1, p, k * step, q, -m * step)), b = project(mix(o, 1, p, k * step, q, m * step));
        path([a[0], a[1], b[0], b[1]]); ctx.stroke();
      }
    }
  }
  function solid() {
    orient();
    if (scene.grid) floor();
    const list = [];
    for (const s of scene.sprites) {
      if (!visible(s)) continue;
      if (s.kind === "trail") { if (trails) trail(s, (k) => project([sample(s.c[0], k), sample(s.c[1], k), sample(s.c[2], k)]).slice(0, 2)); continue; }
      const p = [value(s.c[0]), value(s.c[1]), value(s.c[2])];
      if (s.kind === "text" || s.kind === "ball") { const q = project(p); list.push({ z: q[2] + (s.kind === "ball" ? 0.2 * s.size : cam.extent[0]), ball: s, q }); continue; }
      let place;
      if (s.kind === "placed") {
        const x = unit([value(s.c[3]), value(s.c[4]), value(s.c[5])]);
        let y = [value(s.c[6]), value(s.c[7]), value(s.c[8])];
        y = unit(mix(y, 1, x, -dot(x, y), x, 0));
        const z = cross(x, y);
        place = (v, k) => { const w = mix(x, v[k], y, v[k + 1], z, v[k + 2]); return [p[0] + w[0], p[1] + w[1], p[2] + w[2]]; };
      } else {
        const b = [value(s.c[3]), value(s.c[4]), value(s.c[5])], d = mix(b, 1, p, -1, p, 0), l = Math.sqrt(dot(d, d));
        const e = l > 0 ? unit(d) : [1, 0, 0], least = Math.abs(e[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0];
        const f = unit(mix(least, 1, e, -dot(e, least), e, 0)), g = cross(e, f);
        place = (v, k) => { const u = v[k] * l + v[k + 1], w = mix(e, u, f, v[k + 2], g, v[k + 3]); return [p[0] + w[0], p[1] + w[1], p[2] + w[2]]; };
      }
      for (const mesh of scene.geometries[s.g]) mould(mesh, place, list);
    }
    list.sort((a, b) => a.z - b.z);
    ctx.lineJoin = "round"; ctx.lineCap = "round";
    for (const f of list) {
      if (f.ball) { if (f.ball.kind === "ball") ball(f.ball, f.q); else label(f.ball, f.q[0], f.q[1]); continue; }
      path(f.p, !f.line);
      ctx.strokeStyle = f.color; ctx.lineWidth = f.line ? f.line * px : 0.7 * px;
      if (!f.line) { ctx.fillStyle = f.color; ctx.fill(); }
      ctx.stroke();
    }
    ctx.lineCap = "butt";
    triad();
  }
  function mould(mesh, place, list) {
    const size = mesh.d, m = mesh.p.length / size, at = new Array(m);
    for (let k = 0; k < m; k++) at[k] = project(place(mesh.p, k * size));
    for (const face of mesh.faces) {
      const p = [];
      let z = 0, area = 0;
      for (const k of face) { p.push(at[k][0], at[k][1]); z += at[k][2]; }
      z /= face.length;
      if (mesh.lines) { list.push({ z, p, color: shade(mesh.color, 1 + 0.25 * Math.sin(z / cam.extent[0])), line: mesh.width }); continue; }
      for (let k = 0, j = p.length - 2; k < p.length; j = k, k += 2) area += p[j] * p[k + 1] - p[k] * p[j + 1];
      if (area >= 0) continue;                    // seen from behind (the screen's y axis points down)
      const a = at[face[0]], b = at[face[1]], c = at[face[2]];
      const one = [(b[0] - a[0]) / scale, (a[1] - b[1]) / scale, b[2] - a[2]], two = [(c[0] - b[0]) / scale, (b[1] - c[1]) / scale, c[2] - b[2]];
      const lit = dot(unit(cross(one, two)), LIGHT);
      list.push({ z, p, color: shade(mesh.color, 0.62 + 0.5 * Math.max(0, lit)), line: 0 });
    }
  }
  function ball(s, q) {
    const r = s.size * scale * q[3];
    const g = ctx.createRadialGradient(q[0] - 0.35 * r, q[1] - 0.4 * r, 0.1 * r, q[0], q[1], r);
    g.addColorStop(0, shade(s.color, 1.55)); g.addColorStop(0.55, s.color); g.addColorStop(1, shade(s.color, 0.55));
    ctx.fillStyle = g; ctx.beginPath(); ctx.arc(q[0], q[1], Math.max(r, 0.5), 0, 7); ctx.fill();
  }
  function triad() {
    const o = [44 * px, height - 44 * px], l = 28 * px;
    ctx.font = 12 * px + "px system-ui, sans-serif"; ctx.textAlign = "center"; ctx.lineWidth = 2 * px;
    [["x", "#c8504f"], ["y", "#4f9d69"], ["z", "#3b78b5"]].map(([name, color], k) => {
      const e = [0, 0, 0]; e[k] = 1;
      return { name, color, x: dot(e, R), y: dot(e, U), z: dot(e, V) };
    }).sort((a, b) => a.z - b.z).forEach((a) => {
      ctx.strokeStyle = ctx.fillStyle = a.color;
      path([o[0], o[1], o[0] + a.x * l, o[1] - a.y * l]); ctx.stroke();
      ctx.fillText(a.name, o[0] + a.x * l * 1.35, o[1] - a.y * l * 1.35 + 4 * px);
    });
  }

  // ---- time and controls ------------------------------------------------------------------
  function draw() {
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.fillStyle = "#fbfcfd"; ctx.fillRect(0, 0, width, height);
    ctx.lineJoin = "round";
    if (space) solid(); else plane();
    $("scrub").value = String(Math.round(((time - t0) / (t1 - t0)) * 10000));
    $("clock").textContent = time.toFixed(scene.digits) + " s / " + t1.toFixed(scene.digits) + " s";
  }
  function tick(now) {
    if (!playing) return;
    let t = time + ((now - last) / 1000) * speed;
    last = now;
    if (t >= t1) {
      if (looping) t = t0 + ((t - t0) % (t1 - t0)); else { t = t1; pause(); }
    }
    setTime(t); draw();
    if (playing) requestAnimationFrame(tick);
  }
  function play() {
    if (playing) return;
    if (time >= t1) setTime(t0);
    playing = true; last = performance.now();
    $("play").classList.add("on"); $("play").setAttribute("aria-label", "pause");
    requestAnimationFrame(tick);
  }
  function pause() {
    playing = false; $("play").classList.remove("on"); $("play").setAttribute("aria-label", "play"); draw();
  }
  function seek(t) { setTime(t); draw(); }
  function toggle(id, on) { $(id).classList.toggle("on", on); $(id).setAttribute("aria-pressed", String(on)); draw(); }
  const reset = () => { view = fresh(); if (cam.follow.length) toggle("follow", view.follow); draw(); };

  $("play").onclick = () => (playing ? pause() : play());
  $("scrub").oninput = () => seek(t0 + ($("scrub").value / 10000) * (t1 - t0));
  for (const f of [0.1, 0.2, 0.5, 1, 2, 5, 10]) {
    const o = document.createElement("option");
    o.value = String(scene.speed * f); o.textContent = "× " + parseFloat((scene.speed * f).toPrecision(3));
    o.selected = f === 1; $("speed").append(o);
  }
  $("speed").onchange = () => { speed = Number($("speed").value); };
  $("loop").onclick = () => { looping = !looping; toggle("loop", looping); };
  $("reset").onclick = reset;
  if (scene.sprites.some((s) => s.kind === "trail")) $("trails").onclick = () => { trails = !trails; toggle("trails", trails); };
  else $("trails").remove();
  if (cam.follow.length) $("follow").onclick = () => { view = Object.assign(fresh(), { follow: !view.follow }); toggle("follow", view.follow); };
  else $("follow").remove();
  document.addEventListener("keydown", (e) => {
    if (e.target.tagName === "SELECT") return;
    const step = (t1 - t0) / (e.shiftKey ? 20 : 200);
    const act = { " ": () => (playing ? pause() : play()), ArrowRight: () => seek(time + step), ArrowLeft: () => seek(time - step), Home: () => seek(t0), End: () => seek(t1), r: reset, l: () => $("loop").click() }[e.key];
    if (act) { e.preventDefault(); act(); }
  });
  const pointers = new Map();
  canvas.addEventListener("pointerdown", (e) => { pointers.set(e.pointerId, e); canvas.setPointerCapture(e.pointerId); });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => pointers.delete(e.pointerId));
  canvas.addEventListener("pointermove", (e) => {
    const before = pointers.get(e.pointerId);
    if (!before) return;
    const dx = e.clientX - before.clientX, dy = e.clientY - before.clientY, ratio = width / canvas.clientWidth;
    if (pointers.size === 2) {
      const other = [...pointers.values()].find((p) => p.pointerId !== e.pointerId);
      const gap = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY) || 1;
      view.zoom *= gap(e) / gap(before);
    } else if (space && !(e.buttons & 2) && !e.shiftKey) {
      view.azimuth -= dx * 0.4;
      view.elevation = Math.max(-89, Math.min(89, view.elevation + dy * 0.4));
    } else {
      view.x -= (dx * ratio) / scale; view.y += (dy * ratio) / scale;
    }
    pointers.set(e.pointerId, e); draw();
  });
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("dblclick", reset);
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    const box = canvas.getBoundingClientRect(), ratio = width / box.width, f = Math.exp(-0.0015 * e.deltaY);
    const mx = (e.clientX - box.left) * ratio - width / 2, my = height / 2 - (e.clientY - box.top) * ratio;
    view.x += (mx / scale) * (1 - 1 / f); view.y += (my / scale) * (1 - 1 / f);
    view.zoom = Math.max(0.02, Math.min(200, view.zoom * f)); draw();
  }, { passive: false });
  new ResizeObserver(() => { resize(); draw(); }).observe(canvas.parentElement);
  window.animation = { play, pause, seek, scene, get time() { return time; }, get playing() { return playing; }, get view() { return view; }, set speed(v) { speed = v; } };

  resize();
  const wanted = /[#&]t=([-+.\deE]+)/.exec(location.hash);
  setTime(wanted ? Number(wanted[1]) : t0); draw();
  if (!wanted && !matchMedia("(prefers-reduced-motion: reduce)").matches) play();
})();
