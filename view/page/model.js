// What the page knows of the scene, from the server's messages (view/messages.hpp). Draws nothing.
'use strict';

// Five minutes; the server hands a page that comes late the last one.
const KEPT_S = 300;
const BYTES_OVER_S = 0.5;
const RATE_OVER_RUNS = 5;

// The index of the first entry that is not below the value, in a list that rises.
function firstNotBelow(list, value) {
  let low = 0;
  let high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

// Columns of equal length over a time that rises. Where rows are further apart than the longest step, the line between
// them is broken.
class Columns {
  constructor(names, longestStep) {
    this.names = names;
    this.longestStep = longestStep;
    this.time = [];
    for (const name of names) this[name] = [];
  }

  add(time, row) {
    const last = this.time.at(-1);
    if (last !== undefined && time <= last) return;
    if (last !== undefined && time - last > this.longestStep && this.names.some((name) => this[name].at(-1) !== null))
      this.push((last + time) / 2, this.names.map(() => null));
    this.push(time, row);
  }

  push(time, row) {
    this.time.push(time);
    this.names.forEach((name, i) => this[name].push(row[i]));
  }

  forgetBefore(time) {
    const old = firstNotBelow(this.time, time);
    // Seldom, because it moves all that is kept.
    if (old < this.time.length / 5) return;
    this.time.splice(0, old);
    for (const name of this.names) this[name].splice(0, old);
  }

  // The columns between two times, with a neighbour on either side.
  between(from, to) {
    const begin = Math.max(0, firstNotBelow(this.time, from) - 1);
    const end = firstNotBelow(this.time, to) + 1;
    return [this.time.slice(begin, end), ...this.names.map((name) => this[name].slice(begin, end))];
  }

  // The row at a time, or the last before it.
  at(time) {
    let i = firstNotBelow(this.time, time);
    if (this.time[i] !== time) --i;
    return i < 0 ? null : Object.fromEntries(this.names.map((name) => [name, this[name][i]]));
  }

  has(name) {
    return this[name].some((value) => value !== null);
  }
}

// Counts in bins of time and rows of afferents: a ring over the last minutes.
class Raster {
  constructor(layout) {
    this.bin_s = layout.bin_s;
    this.rows = layout.rows;
    this.patches = layout.patches;
    this.bins = Math.ceil(KEPT_S / layout.bin_s);
    this.counts = new Uint32Array(this.bins * this.rows);
    this.known = new Uint8Array(this.bins);
    this.end = null;  // the bin after the last one
    this.events = 0;
    this.afferents = layout.patches.reduce((sum, patch) => sum + patch.afferents, 0);
    // How many afferents a row stands for.
    this.perRow = new Float64Array(this.rows);
    for (const patch of layout.patches)
      for (let i = 0; i < patch.rows; ++i) this.perRow[patch.first_row + i] += patch.afferents / patch.rows;
  }

  add(run) {
    const bins = run.counts.length / this.rows;
    if (this.end === null) this.end = run.first_bin;
    for (let bin = Math.max(this.end, run.first_bin - this.bins); bin < run.first_bin; ++bin)
      this.known[bin % this.bins] = 0;
    let sum = 0;
    for (let i = 0; i < bins; ++i) {
      const column = (run.first_bin + i) % this.bins;
      // After an interruption a bin may be told of in two parts.
      const isMore = this.isKnown(run.first_bin + i);
      this.known[column] = 1;
      for (let row = 0; row < this.rows; ++row) {
        const count = run.counts[i * this.rows + row];
        const cell = column * this.rows + row;
        this.counts[cell] = isMore ? this.counts[cell] + count : count;
        sum += count;
      }
    }
    this.end = Math.max(this.end, run.first_bin + bins);
    this.events += sum;
    return sum / (bins * this.bin_s * this.afferents);
  }

  isKnown(bin) {
    return bin >= 0 && bin < this.end && bin >= this.end - this.bins && this.known[bin % this.bins] === 1;
  }
}

class Model {
  constructor() {
    this.title = null;
    this.course = 0;  // counts what this page has seen
    this.dropped = 0;
    this.unseen = 0;
    this.ended = false;
    this.clear();
  }

  clear() {
    this.samples = new Columns(['true_n', 'estimate_n', 'sigma_n', 'rate_hz', 'gain', 'emg', 'command', 'doubt'], 0.1);
    this.rates = new Columns(['rate_hz'], 0.2);  // from the raster
    this.bytes = new Columns(['bytes_per_s'], 1);
    this.raster = null;
    this.link = null;
    this.gaps = [];
    this.notes = [];
    this.linkPoints = [];
    this.lastRates = [];
    this.first = null;
    this.last = null;
  }

  take(message) {
    if (message.kind === 'hello') {
      if (message.version !== 1) throw new Error(`the program speaks version ${message.version}: reload the page`);
      const isNew = !this.title || this.title.course !== message.course;
      this.clear();
      if (isNew) ++this.course;
      this.title = message;
      this.dropped = 0;
      this.unseen = 0;
      this.raster = new Raster(message.raster);
      this.addPortion(message.portion);
      message.portion = null;
    } else if (message.kind === 'update') {
      this.unseen = message.unseen;
      this.addPortion(message.portion);
    } else if (message.kind === 'dropped') {
      this.dropped = message.messages;
    }
    this.ended = message.kind === 'end' || message.ended === true;
  }

  addPortion(portion) {
    const { samples } = portion;
    samples.time_s.forEach((time, i) => {
      this.samples.add(time, this.samples.names.map((name) => samples[name][i]));
      this.sawTime(time);
    });
    for (const run of portion.raster) this.addRun(run);
    portion.link_points.time_s.forEach((time, i) => this.addBytes(time, portion.link_points.bytes[i]));
    this.gaps.push(...portion.gaps);
    this.gaps.splice(0, this.gaps.length - 500);
    if (portion.link) this.link = portion.link;
    this.notes.push(...portion.notes);
    this.notes.splice(0, this.notes.length - 100);
    if (this.last !== null)
      for (const columns of [this.samples, this.rates, this.bytes]) columns.forgetBefore(this.last - KEPT_S);
  }

  addRun(run) {
    const rate = this.raster.add(run);
    this.lastRates.push(rate);
    if (this.lastRates.length > RATE_OVER_RUNS) this.lastRates.shift();
    const time = this.raster.end * this.raster.bin_s;
    this.rates.add(time, [this.lastRates.reduce((sum, each) => sum + each, 0) / this.lastRates.length]);
    this.sawTime(time);
  }

  addBytes(time, bytes) {
    const last = this.linkPoints.at(-1);
    // Counts from 0 again, or no time has passed.
    if (last && (bytes < last.bytes || time <= last.time)) {
      if (bytes < last.bytes) this.linkPoints = [];
      return;
    }
    this.linkPoints.push({ time, bytes });
    while (this.linkPoints.length > 2 && time - this.linkPoints[1].time >= BYTES_OVER_S) this.linkPoints.shift();
    const [before] = this.linkPoints;
    if (time - before.time >= BYTES_OVER_S / 2) this.bytes.add(time, [(bytes - before.bytes) / (time - before.time)]);
  }

  sawTime(time) {
    if (this.first === null) this.first = time;
    this.last = Math.max(this.last ?? time, time);
  }
}
