// The picture on the canvas: layers in WebGL2 textures, everything else in the shader, so that no
// control asks the server anything.
import { magnitudes, signs, STEPS } from "./color_map.js";
import { BEHIND, CURVES, fragment, VERTEX } from "./shader.js";

const SAMPLERS = ["first", "other", "ramps", "firstAlpha", "otherAlpha"];
const UNIFORMS = [...SAMPLERS, "behind", "firstSize", "otherSize", "canvasHeight", "zoom", "origin",
                  "curve", "line", "exposure", "gamma", "low", "high", "dither", "clipMarks", "logarithmic"];

export class Picture {
  // `look()` gives what is to be drawn: {first, other, viewport, display, compare}; first and other
  // are LayerImages, other may be null. Throws when the browser has no WebGL2.
  constructor(canvas, look) {
    this.canvas = canvas;
    this.look = look;
    this.textures = new Map(); // by LayerImage
    this.drawings = this.uploads = 0;
    this.gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("This browser has no WebGL2; the PNG link still works.");
    canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); this.lost = true; });
    canvas.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      this.textures.clear();
      this.programs.clear();
      this.build();
      this.draw();
    });
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
    if (width > max || height > max) throw new Error(`${width} × ${height} is above this GPU's ${max}; use the PNG link.`);
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

  // Its alpha's, once the layer's own is up to date; a single 1 when it has none.
  alphaTexture(image) { return (image?.numbers && this.textures.get(image)?.alpha) || this.opaque; }

  upload(image, entry) {
    const { gl } = this;
    this.uploadNumbers(image, entry.texture, gl.RGB, entry.float, image.numbers, 3);
    if (entry.alpha) this.uploadNumbers(image, entry.alpha, gl.RED, entry.float, image.alpha, 1);
    this.uploads += image.changed.size;
    image.changed.clear();
  }

  uploadNumbers(image, texture, format, float, numbers, channels) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, image.width);
    for (const index of image.changed) {
      const { x, y, w, h } = image.block(index);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, w, h, format, float ? gl.FLOAT : gl.HALF_FLOAT, numbers, (y * image.width + x) * channels);
    }
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
  }

  // Frees the GPU's copy of a layer.
  forget(image) {
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
      try { this.paint(this.look()); } catch (error) { this.onError?.(error); }
    });
  }

  paint({ first, other, viewport, display, compare }) {
    const { gl, canvas } = this;
    const layers = [this.texture(first), this.texture(other)];
    [...layers, this.ramps, this.alphaTexture(first), this.alphaTexture(other)].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    const at = this.program({ compare: compare.shown, shownAs: display.shownAs, mean: viewport.zoom < 0.99,
      alpha: Boolean(first?.alpha || other?.alpha) });
    const size = (image) => image ? [image.width, image.height] : [0, 0];
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.uniform2i(at.firstSize, ...size(first));
    gl.uniform2i(at.otherSize, ...size(other));
    gl.uniform1f(at.canvasHeight, canvas.height);
    gl.uniform1f(at.zoom, viewport.zoom);
    gl.uniform2f(at.origin, viewport.x, viewport.y);
    gl.uniform3f(at.line, ...compare.line(canvas.width, canvas.height));
    gl.uniform1i(at.curve, CURVES[display.curve]);
    gl.uniform1i(at.behind, BEHIND[display.behind ?? "black"]);
    for (const name of ["exposure", "gamma", "low", "high"]) gl.uniform1f(at[name], display[name]);
    for (const name of ["dither", "clipMarks", "logarithmic"]) gl.uniform1i(at[name], display[name] ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    this.drawings++;
    this.onDrawn?.();
  }
}
