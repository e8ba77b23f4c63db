// The picture on the canvas: half floats in a WebGL2 texture, exposure and the sRGB curve in the
// shader, so that moving the exposure asks the server nothing.

const VERTEX = `#version 300 es
out vec2 at;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  at = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D picture;
uniform float scale;
uniform float offset;
in vec2 at;
out vec4 color;
void main() {
  vec3 linear = clamp(texture(picture, at).rgb * scale + offset, 0.0, 1.0);
  vec3 high = 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055;
  color = vec4(mix(high, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308))), 1.0);
}`;

export class Picture {
  // Throws when the browser has no WebGL2.
  constructor(canvas) {
    this.canvas = canvas;
    this.width = this.height = 0;
    this.exposure = 0;
    this.normals = false;
    this.pixelsSet = 0;
    this.gl = canvas.getContext("webgl2", { alpha: false, antialias: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("This browser has no WebGL2; the PNG link still works.");
    canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); this.lost = true; });
    canvas.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      this.build();
      const { width, height } = this;
      this.width = this.height = 0;
      this.resize(width, height);
      this.onRestored?.();
    });
    this.build();
  }

  build() {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.scale = gl.getUniformLocation(program, "scale");
    this.offset = gl.getUniformLocation(program, "offset");
    gl.bindVertexArray(gl.createVertexArray());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  }

  // A new, black picture of that size; keeps the one that is there when the size is the same.
  resize(width, height) {
    if (width === this.width && height === this.height) return;
    const { gl } = this;
    const max = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (width > max || height > max) throw new Error(`${width} × ${height} is above this GPU's ${max}; use the PNG link.`);
    this.width = this.canvas.width = width;
    this.height = this.canvas.height = height;
    if (this.texture) gl.deleteTexture(this.texture);
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGB16F, width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    this.clear();
  }

  clear() {
    if (!this.width) return;
    const row = new Uint16Array(this.width * 3);
    for (let y = 0; y < this.height; y++) this.upload(0, y, this.width, 1, row);
    this.pixelsSet = 0;
    this.draw();
  }

  upload(x, y, w, h, pixels) {
    const { gl } = this;
    gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, w, h, gl.RGB, gl.HALF_FLOAT, pixels);
  }

  // A block of the pixel feed.
  put(block) {
    if (block.w === 0) { this.resize(block.x, block.y); return; }
    if (this.lost || block.x + block.w > this.width || block.y + block.h > this.height) return;
    this.upload(block.x, block.y, block.w, block.h, block.pixels);
    this.pixelsSet += block.w * block.h;
    this.draw();
  }

  setExposure(ev) { this.exposure = ev; this.draw(); }

  // Normals lie in [-1, 1]: shown as (n + 1) / 2, without exposure.
  setNormals(on) { this.normals = on; this.draw(); }

  // At most one drawing a displayed frame, however many blocks came.
  draw() {
    if (this.pending || !this.width) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      if (this.lost) return;
      const { gl } = this;
      gl.viewport(0, 0, this.width, this.height);
      gl.uniform1f(this.scale, this.normals ? 0.5 : 2 ** this.exposure);
      gl.uniform1f(this.offset, this.normals ? 0.5 : 0);
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    });
  }
}
