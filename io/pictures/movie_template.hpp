// The page of a movie, without its data: plain HTML and script for any browser. Its strings are in single
// quotes, so that this literal ends where it should.
#pragma once

#include <string_view>

namespace afferent {

inline constexpr std::string_view movie_template = R"(<!DOCTYPE html>
<html lang='en'>
<head>
<meta charset='utf-8'>
<meta name='viewport' content='width=device-width, initial-scale=1'>
<title>Afferents</title>
<style>
  body { margin: 0 auto; max-width: 1180px; padding: 12px 16px; background: #fff; color: #404040;
         font: 14px 'Liberation Sans', Arial, Helvetica, sans-serif; }
  h1 { font-size: 18px; font-weight: normal; margin: 0 0 6px; }
  canvas { width: 100%; display: block; }
  #raster { cursor: crosshair; }
  #controls { display: flex; flex-wrap: wrap; gap: 12px; align-items: center; margin: 8px 0; }
  #controls button { width: 84px; padding: 4px; }
  #time { flex: 1; min-width: 160px; }
  #clock { font-variant-numeric: tabular-nums; min-width: min(250px, 100%); text-align: right; }
  #note { font-size: 12px; margin: 6px 0; }
</style>
</head>
<body>
<h1 id='title'></h1>
<canvas id='maps'></canvas>
<div id='controls'>
  <button id='play' title='Space'>Pause</button>
  <input id='time' type='range' min='0' max='10000' value='0' step='1' aria-label='Time'>
  <label>Speed <select id='speed'></select></label>
  <span id='clock'></span>
</div>
<canvas id='raster'></canvas>
<p id='note'></p>
<noscript>This movie is drawn by a script in this page, and scripts are switched off.</noscript>
<script>
'use strict';
const data = {/*data*/};

// ---- data
const bytesOf = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
const view = (text, Type) => new Type(bytesOf(text).buffer);
const places = view(data.places, Float32Array);
const kindOf = view(data.kindOf, Uint8Array);
const rowOf = view(data.rowOf, Uint32Array);
const times = view(data.times, Uint32Array);  // microseconds since the beginning
const addresses = view(data.addresses, Uint32Array);
const afferents = rowOf.length;
const length = data.end_s - data.begin_s;
const pressure = data.pressure && {
  interval: data.pressure.interval_s,
  highest: data.pressure.highest_kpa,
  cells: view(data.pressure.cells, Float32Array),
  ends: view(data.pressure.ends, Uint32Array),
  pressed: view(data.pressure.pressed, Uint32Array),
  levels: view(data.pressure.levels, Uint8Array),
};
const number = value => value.toLocaleString('en');

// The index of the first event at that time or later.
function eventAt(us) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < us) low = middle + 1; else high = middle;
  }
  return low;
}

// The rate of an afferent is what it has fired in the last `span_us`.
const span_us = Math.min(50000, length * 1e6 / 4);
const counts = new Uint16Array(afferents);
const active = new Set();
let head = 0, tail = 0;
function moveTo(us) {
  const begin = eventAt(us - span_us), end = eventAt(us + 1);
  if (begin < tail || end < head || begin > head) {
    for (const address of active) counts[address] = 0;
    active.clear();
    head = tail = begin;
  }
  for (; head < end; ++head) {
    ++counts[addresses[head]];
    active.add(addresses[head]);
  }
  for (; tail < begin; ++tail) if (--counts[addresses[tail]] === 0) active.delete(addresses[tail]);
}

// The highest count of all, by which colours are scaled.
let highest = 1;
{
  const window = new Uint16Array(afferents);
  for (let first = 0, last = 0; last < times.length; ++last) {
    while (times[last] - times[first] > span_us) --window[addresses[first++]];
    highest = Math.max(highest, ++window[addresses[last]]);
  }
}
const scale_hz = highest * 1e6 / span_us;

function rateColour(share) {
  const at = Math.min(1, Math.max(0, share)) * (data.rateStops.length - 1);
  const low = Math.min(Math.floor(at), data.rateStops.length - 2);
  const parts = [0, 1, 2].map(i => Math.round(data.rateStops[low][i] +
    (at - low) * (data.rateStops[low + 1][i] - data.rateStops[low][i])));
  return 'rgb(' + parts.join() + ')';
}
const colours = Array.from({length: highest + 1}, (_, count) => rateColour(count / highest));

// ---- the skin from above
const mapsCanvas = document.getElementById('maps'), rasterCanvas = document.getElementById('raster');
const box = {x0: Infinity, x1: -Infinity, y0: Infinity, y1: -Infinity};
function widen(x, y) {
  if (!(x === x && y === y)) return;
  box.x0 = Math.min(box.x0, x); box.x1 = Math.max(box.x1, x);
  box.y0 = Math.min(box.y0, y); box.y1 = Math.max(box.y1, y);
}
for (const outline of data.outlines) for (const [x, y] of outline) widen(x, y);
for (let i = 0; i < afferents; ++i) widen(places[2 * i], places[2 * i + 1]);
const margin = 0.03 * Math.max(box.x1 - box.x0, box.y1 - box.y0, 0.1);
box.x0 -= margin; box.x1 += margin; box.y0 -= margin; box.y1 += margin;

const ratio = Math.max(1, Math.min(3, window.devicePixelRatio || 1));
// Drawn as wide as it is shown, so that text keeps its size. Where that is narrow, as on a phone, legends stand below the maps
// and on the spikes, and not beside them.
const width = Math.max(300, Math.min(1180, mapsCanvas.clientWidth || 1180)), narrow = width < 720;
const legend = narrow ? 0 : 150, gap = 18, titleHeight = 26;
const columns = Math.min(narrow ? 1 : 3, data.kinds.length), mapRows = Math.ceil(data.kinds.length / columns);
const room = (width - legend) / columns - gap;
const pxPerMm = Math.min(room / (box.x1 - box.x0), 360 / (box.y1 - box.y0));
const mapHeight = (box.y1 - box.y0) * pxPerMm;
const mapsBottom = mapRows * (mapHeight + titleHeight + 22);
const legendTop = narrow ? mapsBottom + 24 : titleHeight + 10;
const mapsHeight = narrow ? legendTop + 144 : Math.max(190, mapsBottom);
function size(canvas, height) {
  canvas.width = width * ratio; canvas.height = height * ratio;
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return pen;
}
const pen = size(mapsCanvas, mapsHeight);
const left = kind => (kind % columns) * ((width - legend) / columns);
const top_ = kind => titleHeight + Math.floor(kind / columns) * (mapHeight + titleHeight + 22);
const px = (kind, x) => left(kind) + (x - box.x0) * pxPerMm;
const py = (kind, y) => top_(kind) + (box.y1 - y) * pxPerMm;
const perKind = data.kinds.map((_, kind) => kindOf.reduce((sum, k) => sum + (k === kind), 0));
const area = (box.x1 - box.x0) * (box.y1 - box.y0);
const radius = perKind.map(count => Math.max(0.6, Math.min(7, 0.3 * pxPerMm * Math.sqrt(area / Math.max(1, count)))));

// Shapes differ by kind, as in the picture: circle, triangle, diamond, square.
function shape(pen, kind, x, y, r) {
  pen.beginPath();
  if (r < 1.5) pen.rect(x - r, y - r, 2 * r, 2 * r);
  else if (kind % 4 === 0) pen.arc(x, y, r, 0, 2 * Math.PI);
  else if (kind % 4 === 1) { pen.moveTo(x, y - 1.2 * r); pen.lineTo(x + 1.1 * r, y + 0.8 * r); pen.lineTo(x - 1.1 * r, y + 0.8 * r); pen.closePath(); }
  else if (kind % 4 === 2) { pen.moveTo(x, y - 1.3 * r); pen.lineTo(x + 1.3 * r, y); pen.lineTo(x, y + 1.3 * r); pen.lineTo(x - 1.3 * r, y); pen.closePath(); }
  else pen.rect(x - r, y - r, 2 * r, 2 * r);
}
function trace(pen, kind, outline) {
  pen.beginPath();
  outline.forEach(([x, y], i) => i ? pen.lineTo(px(kind, x), py(kind, y)) : pen.moveTo(px(kind, x), py(kind, y)));
  pen.closePath();
}
function layer(height, draw) {
  const canvas = document.createElement('canvas');
  draw(size(canvas, height));
  return canvas;
}
// What does not move: below the pressure the skin, above it names, outlines and silent afferents.
const below = layer(mapsHeight, pen => {
  pen.fillStyle = '#FBF8F5';
  data.kinds.forEach((_, kind) => data.outlines.forEach(outline => { trace(pen, kind, outline); pen.fill(); }));
});
const above = layer(mapsHeight, pen => {
  data.kinds.forEach((kind, k) => {
    pen.font = '16px Liberation Sans, Arial, sans-serif'; pen.fillStyle = kind.colour;
    pen.fillText(kind.name, left(k), top_(k) - 9);
    const after = left(k) + pen.measureText(kind.name).width + 10;
    pen.font = '13px Liberation Sans, Arial, sans-serif'; pen.fillStyle = '#404040';
    pen.fillText(number(perKind[k]) + ' afferents', after, top_(k) - 9);
    pen.strokeStyle = '#B8B8B8'; pen.lineWidth = 1;
    data.outlines.forEach(outline => { trace(pen, k, outline); pen.stroke(); });
  });
  pen.strokeStyle = pen.fillStyle = '#B8B8B8'; pen.lineWidth = 0.8;
  for (let i = 0; i < afferents; ++i) {
    if (places[2 * i] !== places[2 * i]) continue;
    const k = kindOf[i];
    const small = radius[k] < 2.5;
    shape(pen, k, px(k, places[2 * i]), py(k, places[2 * i + 1]), small ? 0.4 : 0.55 * radius[k]);
    if (small) pen.fill(); else pen.stroke();
  }
  // The scale of lengths: 1, 2 or 5 times a power of ten.
  const third = (box.x1 - box.x0) / 3, power = 10 ** Math.floor(Math.log10(third));
  const bar = power * (third >= 5 * power ? 5 : third >= 2 * power ? 2 : 1);
  const y = top_(0) + mapHeight + 12;
  pen.strokeStyle = '#404040'; pen.lineWidth = 2;
  pen.beginPath(); pen.moveTo(left(0), y); pen.lineTo(left(0) + bar * pxPerMm, y); pen.stroke();
  pen.fillStyle = '#404040'; pen.fillText(bar + ' mm', left(0) + bar * pxPerMm + 8, y + 4);
  // The scale of colours.
  const x = narrow ? 0 : width - legend + 14, top = legendTop;
  pen.fillText('Spike rate', x, top - 12);
  for (let i = 0; i < 90; ++i) { pen.fillStyle = rateColour(1 - i / 90); pen.fillRect(x, top + i, 16, 1.5); }
  pen.fillStyle = '#404040';
  [[0, 90], [0.5, 45], [1, 0]].forEach(([share, at]) =>
    pen.fillText((share * scale_hz).toPrecision(3).replace(/\.0*$/, '') + ' Hz', x + 22, top + at + 4));
  pen.fillText('dark rim: fires now', x, top + 114);
  if (pressure) {
    pen.fillStyle = '#969696'; pen.fillRect(x, top + 124, 12, 12);
    pen.fillStyle = '#404040'; pen.fillText(pressure.highest.toPrecision(3).replace(/\.0*$/, '') + ' kPa on the skin', x + 18, top + 134);
  }
});

function drawMaps(us, frame_us) {
  moveTo(us);
  pen.clearRect(0, 0, width, mapsHeight);
  pen.drawImage(below, 0, 0, width, mapsHeight);
  if (pressure && pressure.ends.length) {
    const frame = Math.min(pressure.ends.length - 1, Math.floor(us * 1e-6 / pressure.interval + 1e-9));
    for (let i = frame ? pressure.ends[frame - 1] : 0; i < pressure.ends[frame]; ++i) {
      const cell = 3 * pressure.pressed[i], grey = Math.round(242 - 92 * pressure.levels[i] / 255);
      const half = pressure.cells[cell + 2] / 2, side = pressure.cells[cell + 2] * pxPerMm + 0.3;
      pen.fillStyle = 'rgb(' + grey + ',' + grey + ',' + grey + ')';
      data.kinds.forEach((_, k) => pen.fillRect(px(k, pressure.cells[cell] - half), py(k, pressure.cells[cell + 1] + half), side, side));
    }
  }
  pen.drawImage(above, 0, 0, width, mapsHeight);
  for (const i of active) {
    if (places[2 * i] !== places[2 * i]) continue;
    const k = kindOf[i];
    shape(pen, k, px(k, places[2 * i]), py(k, places[2 * i + 1]), radius[k]);
    pen.fillStyle = colours[counts[i]];
    pen.fill();
  }
  // Each spike has a dark rim in at least one frame.
  pen.strokeStyle = '#202020'; pen.lineWidth = 1.6;
  for (let i = eventAt(us - Math.max(1000, frame_us) + 1); i < head; ++i) {
    const a = addresses[i], k = kindOf[a];
    if (places[2 * a] !== places[2 * a] || radius[k] < 1.5) continue;
    shape(pen, k, px(k, places[2 * a]), py(k, places[2 * a + 1]), radius[k] + 1);
    pen.stroke();
  }
}

// ---- the spikes
const rasterHeight = 340, rasterLeft = 46, rasterRight = width - (narrow ? 14 : legend), axis = 40, plot = rasterHeight - axis;
const rasterPen = size(rasterCanvas, rasterHeight);
const timeX = us => rasterLeft + us * 1e-6 / length * (rasterRight - rasterLeft);
const raster = layer(rasterHeight, pen => {
  const perRow = plot / afferents, mark = Math.max(1.6, 0.9 * perRow);
  pen.globalAlpha = times.length > 300000 ? 0.25 : 1;
  for (let i = 0; i < times.length; ++i) {
    const a = addresses[i];
    pen.fillStyle = data.kinds[kindOf[a]].colour;
    pen.fillRect(timeX(times[i]), rowOf[a] * perRow, 1, mark);
  }
  pen.globalAlpha = 1;
  pen.font = '13px Liberation Sans, Arial, sans-serif';
  const spikes = data.kinds.map(() => 0);
  for (let i = 0; i < addresses.length; ++i) ++spikes[kindOf[addresses[i]]];
  data.kinds.forEach((kind, k) => {
    const y = Math.min(plot - 16, Math.max(15, (kind.first + kind.rows / 2) * perRow));
    const x = narrow ? rasterLeft + 6 : rasterRight + 14, count = number(spikes[k]) + ' spikes';
    if (narrow) {
      pen.fillStyle = 'rgba(255, 255, 255, 0.8)';
      pen.fillRect(x - 3, y - 15, Math.max(pen.measureText(kind.name).width, pen.measureText(count).width) + 6, 33);
    }
    pen.fillStyle = kind.colour; pen.fillText(kind.name, x, y - 3);
    pen.fillStyle = '#404040'; pen.fillText(count, x, y + 13);
    if (k) { pen.fillStyle = '#808080'; pen.fillRect(rasterLeft, kind.first * perRow, rasterRight - rasterLeft, 1); }
  });
  pen.fillStyle = '#404040';
  pen.fillRect(rasterLeft, 0, 1, plot); pen.fillRect(rasterLeft, plot, rasterRight - rasterLeft, 1);
  const sixth = length / (narrow ? 4 : 6), power = 10 ** Math.floor(Math.log10(sixth));
  const step = power * (sixth >= 5 * power ? 5 : sixth >= 2 * power ? 2 : 1);
  pen.textAlign = 'center';
  for (let i = Math.ceil(data.begin_s / step - 1e-9); i * step <= data.end_s + 1e-9; ++i) {
    const x = timeX((i * step - data.begin_s) * 1e6);
    pen.fillRect(x, plot, 1, 5);
    pen.fillText(+(i * step).toPrecision(6), x, plot + 18);
  }
  pen.fillText('Time (s)', (rasterLeft + rasterRight) / 2, plot + 32);
  pen.save(); pen.translate(14, plot / 2); pen.rotate(-Math.PI / 2);
  pen.fillText('by kind, and place ' + data.direction, 0, 0); pen.restore();
});
function drawRaster(us) {
  rasterPen.clearRect(0, 0, width, rasterHeight);
  const from = timeX(Math.max(0, us - span_us));
  rasterPen.fillStyle = '#F3ECDD'; rasterPen.fillRect(from, 0, timeX(us) - from, plot);
  rasterPen.drawImage(raster, 0, 0, width, rasterHeight);
  rasterPen.fillStyle = '#202020'; rasterPen.fillRect(timeX(us), 0, 1.5, plot);
}

// ---- time
const speeds = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const select = document.getElementById('speed'), slider = document.getElementById('time');
const play = document.getElementById('play'), clock = document.getElementById('clock');
for (const slower of speeds) select.add(new Option(slower === 1 ? 'real time' : slower + ' times slower', slower));
// Some twelve seconds for a short scene; a long one in real time.
select.value = speeds.reduce((best, s) => Math.abs(Math.log(length * s / 12)) < Math.abs(Math.log(length * best / 12)) ? s : best);
let now_us = 0, playing = true, last = null;
function show(frame_us) {
  drawMaps(now_us, frame_us);
  drawRaster(now_us);
  slider.value = Math.round(1e4 * now_us * 1e-6 / length);
  const slower = +select.value;
  clock.textContent = (data.begin_s + now_us * 1e-6).toFixed(4) + ' s, ' +
    (playing ? (slower === 1 ? 'in real time' : slower + ' times slower than real') : 'paused');
}
function setPlaying(on) { playing = on; last = null; play.textContent = on ? 'Pause' : 'Play'; show(0); }
function goTo(us) { now_us = Math.max(0, Math.min(length * 1e6, us)); show(0); }
function step(at) {
  if (playing) {
    const frame_us = last === null ? 0 : Math.min(100, at - last) * 1e3 / +select.value;
    last = at;
    now_us += frame_us;
    if (now_us >= length * 1e6) now_us = 0;
    show(frame_us);
  }
  requestAnimationFrame(step);
}
play.onclick = () => setPlaying(!playing);
slider.oninput = () => { setPlaying(false); goTo(slider.value / 1e4 * length * 1e6); };
select.onchange = () => show(0);
rasterCanvas.onpointerdown = event => {
  const inside = event.offsetX / rasterCanvas.clientWidth * width;
  goTo((inside - rasterLeft) / (rasterRight - rasterLeft) * length * 1e6);
};
document.onkeydown = event => {
  if (event.target === select) return;
  if (event.key === ' ') { event.preventDefault(); if (event.target !== play) setPlaying(!playing); else play.click(); }
  if (event.target === slider) return;
  if (event.key === 'ArrowRight' || event.key === 'ArrowLeft') { setPlaying(false); goTo(now_us + (event.key === 'ArrowRight' ? 1000 : -1000)); }
};

document.title = data.title || document.title;
document.getElementById('title').textContent = data.title;
document.getElementById('note').textContent =
  'Colour: spikes in the last ' + +(span_us / 1000).toPrecision(3) + ' ms, which are shaded below. ' + number(times.length) + ' spikes' +
  (times.length > 300000 ? ', more than can be told apart below: the darker, the more. ' : '. ') +
  (pressure ? 'Grey: pressure, every ' + +(pressure.interval * 1000).toPrecision(3) + ' ms. ' : 'What pressed the skin is not known. ') +
  'Space plays and pauses; arrows step by 1 ms; a click into the spikes goes there.';
// movie.html#t=0.5 opens at that time.
const at = /t=([0-9.]+)/.exec(location.hash);
if (at) { setPlaying(false); goTo((+at[1] - data.begin_s) * 1e6); }
else if (window.matchMedia && matchMedia('(prefers-reduced-motion: reduce)').matches) setPlaying(false);
requestAnimationFrame(step);
</script>
</body>
</html>
)";

}  // namespace afferent
