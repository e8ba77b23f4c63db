// The picture on the canvas: layers in WebGL2 textures, everything else in the shader, so that no
// control asks the server anything.
//
// Where the browser draws without a GPU, drawing all of the canvas takes tens of milliseconds of the
// page's own time. So only blocks that have changed are drawn again where nothing else has, and while
// the camera is being moved the canvas has fewer pixels, if drawing was seen to be slow.
import { magnitudes, signs, STEPS } from "./color_map.js";
import { BEHIND, fragment, VERTEX } from "./shader.js";

const SAMPLERS = ["first", "other", "ramps", "firstAlpha", "otherAlpha"];
const UNIFORMS = [...SAMPLERS, "behind", "firstSize", "otherSize", "firstTexels", "otherTexels", "canvasHeight", "zoom", "origin",
                  "line", "exposure", "gamma", "low", "high", "dither", "clipMarks", "logarithmic"];

const SLOW_MS = 8; // for all of the canvas: no GPU
const BLOCKS_MAX = 64; // that are drawn one by one
const EDGE_PX = 2; // of the canvas around a block: a mean over its edge changes, too

export class Picture {
  // `look()` gives what is to be drawn: {first, other, viewport, display, compare}; first and other
  // are LayerImages, other may be null; hurried: pixels soon count for more than their number. Throws when the browser has no WebGL2.
  constructor(canvas, look) {
    this.canvas = canvas;
    this.look = look;
    this.textures = new Map(); // by LayerImage
    this.coarse = new Map(); // by LayerImage, those that are coarse, by width
    this.fresh = new Map(); // by LayerImage: blocks that are other than when it was drawn last
    this.drawings = this.uploads = 0;
    this.costMs = 0; // of drawing all of a full canvas, until the browser has it
    this.after = new MessageChannel();
    this.after.port1.onmessage = () => this.shown();
    this.gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("This browser has no WebGL2; the PNG link still works.");
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault(); // or it would not be given back
      this.lost = true;
      this.onLost?.(true);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      if (this.gl.isContextLost()) return; // once more already
      this.lost = false;
      this.textures.clear();
      this.coarse.clear();
      this.programs.clear();
      this.last = null;
      this.build();
      this.onLost?.(false);
      this.draw();
    });
    this.lost = this.gl.isContextLost();
    this.programs = new Map(); // by the kind of picture, as fragment() has it
    this.build();
  }

  // The program of a kind of picture, in use, and where its uniforms are.
  program(kind) {
    const { gl } = this, key = JSON.stringify(kind), known = this.programs.get(key);
    if (known) { gl.useProgram(known.program); return known.at; }
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment(kind)]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    const at = Object.fromEntries(UNIFORMS.map((name) => [name, gl.getUniformLocation(program, name)]));
    SAMPLERS.forEach((name, unit) => gl.uniform1i(at[name], unit));
    this.programs.set(key, { program, at });
    return at;
  }

  build() {
    const { gl } = this;
    gl.bindVertexArray(gl.createVertexArray());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.blank = this.makeTexture(gl.RGB16F, 1, 1);
    this.opaque = this.makeTexture(gl.R8, 1, 1);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, 1, 1, gl.RED, gl.UNSIGNED_BYTE, Uint8Array.of(255));
    this.ramps = this.makeTexture(gl.RGBA8, STEPS, 2);
    [magnitudes(), signs()].forEach((ramp, row) =>
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, row, STEPS, 1, gl.RGBA, gl.UNSIGNED_BYTE, ramp));
  }

  makeTexture(format, width, height) {
    const { gl } = this;
    const max = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (max && (width > max || height > max)) throw new Error(`${width} × ${height} is above this GPU's ${max}; use the PNG link.`);
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }

  // The layer's texture, with what has changed since it was drawn last.
  texture(image) {
    if (!image?.numbers) return this.blank;
    if (image.coarseShown) return this.coarseTexture(image);
    const { gl } = this;
    let entry = this.textures.get(image);
    if (entry && (entry.width !== image.width || entry.height !== image.height || entry.float !== image.isFloat())) {
      this.forget(image);
      entry = null;
    }
    if (!entry) {
      const { width, height } = image, float = image.isFloat();
      entry = { width, height, float, texture: this.makeTexture(float ? gl.RGB32F : gl.RGB16F, width, height), alpha: null };
      this.textures.set(image, entry);
      image.touch();
    }
    if (entry.alpha && !image.alpha) { // a coarse view, or another job's picture, has none
      this.gl.deleteTexture(entry.alpha);
      entry.alpha = null;
    }
    if (image.alpha && !entry.alpha) {
      entry.alpha = this.makeTexture(entry.float ? gl.R32F : gl.R16F, entry.width, entry.height);
      image.touch();
    }
    if (image.changed.size > 0) this.upload(image, entry);
    return entry.texture;
  }

  // A coarse picture goes to the GPU as it is: stretched it would be sixteen times the bytes, and the
  // first pixels of a move wait for them.
  coarseTexture(image) {
    const { gl } = this, { width, height, numbers } = image.coarseShown, float = image.isFloat();
    const known = this.coarse.get(image) ?? new Map(), key = `${width} ${height} ${float}`, isNew = !known.has(key);
    if (isNew) known.set(key, this.makeTexture(float ? gl.RGB32F : gl.RGB16F, width, height));
    this.coarse.set(image, known);
    if (isNew || image.changed.size > 0) {
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, known.get(key));
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGB, float ? gl.FLOAT : gl.HALF_FLOAT, numbers);
      this.uploads += image.changed.size;
      this.fresh.set(image, [...image.changed]);
      image.changed.clear();
    }
    return known.get(key);
  }

  // Its alpha's, once the layer's own is up to date; a single 1 when it has none.
  alphaTexture(image) { return (image?.numbers && image.alpha && this.textures.get(image)?.alpha) || this.opaque; }

  upload(image, entry) {
    const { gl } = this;
    this.uploadNumbers(image, entry.texture, gl.RGB, entry.float, image.numbers, 3);
    if (entry.alpha) this.uploadNumbers(image, entry.alpha, gl.RED, entry.float, image.alpha, 1);
    this.uploads += image.changed.size;
    this.fresh.set(image, [...image.changed]);
    image.changed.clear();
  }

  uploadNumbers(image, texture, format, float, numbers, channels) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, image.width);
    const blocks = image.changed.size < image.columns * image.rows ? [...image.changed].map((index) => image.block(index))
      : [{ x: 0, y: 0, w: image.width, h: image.height }]; // calls cost more than bytes
    for (const { x, y, w, h } of blocks) {
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, w, h, format, float ? gl.FLOAT : gl.HALF_FLOAT, numbers, (y * image.width + x) * channels);
    }
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
  }

  // Frees the GPU's copy of a layer.
  forget(image) {
    for (const texture of this.coarse.get(image)?.values() ?? []) this.gl.deleteTexture(texture);
    this.coarse.delete(image);
    const entry = this.textures.get(image);
    if (!entry) return;
    this.gl.deleteTexture(entry.texture);
    if (entry.alpha) this.gl.deleteTexture(entry.alpha);
    this.textures.delete(image);
  }

  // At most one drawing a displayed frame, however many blocks came.
  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      if (this.lost || !this.canvas.width) return;
      this.beganAt = performance.now();
      try { this.paint(this.look()); } catch (error) {
        this.last = null;
        if (!this.gl.isContextLost()) this.onError?.(error); // else onLost says so
      }
      this.after.port2.postMessage(null); // comes when the browser has taken the canvas
    });
  }

  // What was drawn is out of the page's hands: without a GPU that is when its pixels are there.
  shown() {
    if (this.whole) this.costMs = this.costMs ? 0.7 * this.costMs + 0.3 * (performance.now() - this.beganAt) : performance.now() - this.beganAt;
    this.whole = false;
    this.onShown?.();
  }

  // The canvas's pixels for each of those that it should have, along each axis. A coarse picture has
  // none to lose. What is there already is not drawn anew for fewer.
  share({ first, hurried }) {
    if (!hurried || this.costMs < SLOW_MS) return 1;
    if (this.last && !first?.changed.size) return this.last.share;
    return first?.detail >= 4 ? 1 / 4 : 1 / 2;
  }

  resize({ width, height }, share) {
    const { canvas } = this, wide = Math.ceil(width * share), tall = Math.ceil(height * share);
    canvas.dataset.share = String(share);
    if (canvas.width === wide && canvas.height === tall) return;
    canvas.width = wide;
    canvas.height = tall;
    this.last = null;
  }

  // The parts of the canvas that are to be drawn, {x, y, w, h} from its lower left corner: all of it as
  // [null], none as [].
  parts(now, images, { zoom, x, y }, share) {
    const { last, canvas } = this, changed = images.map((image) => this.fresh.get(image) ?? []);
    const same = last && now === last.now && images.every((image, i) => image === last.images[i]);
    this.last = { now, images, share };
    const count = changed[0].length + changed[1].length;
    if (!same || count > BLOCKS_MAX || images.some((image, i) => image && 2 * changed[i].length > image.columns * image.rows)) return [null];
    return images.flatMap((image, i) => changed[i].map((index) => {
      const block = image.block(index), left = Math.floor((block.x - x) * zoom) - EDGE_PX, top = Math.floor((block.y - y) * zoom) - EDGE_PX;
      const w = Math.ceil(block.w * zoom) + 2 * EDGE_PX + 1, h = Math.ceil(block.h * zoom) + 2 * EDGE_PX + 1;
      return { x: left, y: canvas.height - top - h, w, h };
    }));
  }

  paint(what) {
    const { first, other, viewport, display, compare, hurried } = what, { gl, canvas } = this;
    const share = this.share(what);
    this.resize(viewport.canvas, share);
    this.fresh.clear();
    const layers = [this.texture(first), this.texture(other)];
    const isPicture = display.shownAs === "picture" && compare.shown !== "difference"; // a difference is no light
    const kind = { compare: compare.shown, shownAs: display.shownAs, curve: isPicture ? display.curve : "linear", mean: viewport.zoom < 0.99 && !(hurried && share < 1),
      alpha: Boolean(first?.alpha || other?.alpha) };
    const zoom = viewport.zoom * share, line = compare.line(canvas.width, canvas.height);
    const shown = ["behind", "exposure", "gamma", "low", "high", "dither", "clipMarks", "logarithmic"].map((name) => display[name]);
    const sizes = [first, other].map((image) => image && [image.width, image.height, Boolean(image.numbers), image.detail]);
    const now = JSON.stringify([kind, zoom, viewport.x, viewport.y, line, shown, sizes]);
    const parts = this.parts(now, [first, other], { zoom, x: viewport.x, y: viewport.y }, share);
    if (parts.length > 0) {
      [...layers, this.ramps, this.alphaTexture(first), this.alphaTexture(other)].forEach((texture, unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
      });
      this.setUniforms(this.program(kind), what, zoom, line);
      this.drawParts(parts);
      this.whole = parts[0] === null && share === 1;
    }
    this.onDrawn?.();
  }

  setUniforms(at, { first, other, viewport, display }, zoom, line) {
    const { gl, canvas } = this, size = (image) => image ? [image.width, image.height] : [0, 0];
    const texels = (image) => image?.coarseShown ? [image.coarseShown.width / image.width, image.coarseShown.height / image.height] : [1, 1];
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.uniform2i(at.firstSize, ...size(first));
    gl.uniform2i(at.otherSize, ...size(other));
    gl.uniform2f(at.firstTexels, ...texels(first));
    gl.uniform2f(at.otherTexels, ...texels(other));
    gl.uniform1f(at.canvasHeight, canvas.height);
    gl.uniform1f(at.zoom, zoom);
    gl.uniform2f(at.origin, viewport.x, viewport.y);
    gl.uniform3f(at.line, ...line);
    gl.uniform1i(at.behind, BEHIND[display.behind ?? "black"]);
    for (const name of ["exposure", "gamma", "low", "high"]) gl.uniform1f(at[name], display[name]);
    for (const name of ["dither", "clipMarks", "logarithmic"]) gl.uniform1i(at[name], display[name] ? 1 : 0);
  }

  drawParts(parts) {
    const { gl } = this;
    for (const part of parts) {
      if (part) {
        gl.enable(gl.SCISSOR_TEST);
        gl.scissor(part.x, part.y, part.w, part.h);
      }
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
    gl.disable(gl.SCISSOR_TEST);
    this.drawings++;
  }
}
