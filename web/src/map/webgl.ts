// The WebGL2 renderer: quads are built into one buffer, and one call draws all vehicles. Instancing is avoided because a
// software rasteriser pays for each instance. There are no shadows, blur or antialiasing buffers: the fragment shader knows
// the distance of every edge.
import { resize_canvas } from './canvas';
import { packed, type Colours, type Renderer } from './renderer';
import type { Size } from './view';
import { Quads, vertices_per_quad, words_per_quad, words_per_vertex } from './webgl_quads';
import { body_fragment, body_vertex, line_fragment, line_vertex, spot_fragment, spot_vertex, type Detail } from './webgl_shader';

interface Program {
  program: WebGLProgram;
  uniforms: Map<string, WebGLUniformLocation | null>;
}

export class WebglRenderer extends Quads implements Renderer {
  readonly kind = 'webgl2';
  private readonly gl: WebGL2RenderingContext;
  private readonly line_program: Program;
  private readonly spot_program: Program;
  private readonly body_programs: Readonly<Record<Detail, Program>>;
  private readonly vertices: WebGLBuffer;
  private readonly indices: WebGLBuffer;
  /** capacity of the GPU buffer [quads] */
  private uploaded = 0;

  /** Null if the browser has no WebGL2 or cannot build the shaders. */
  static make(canvas: HTMLCanvasElement): WebglRenderer | null {
    const gl = canvas.getContext('webgl2', { alpha: true, antialias: false, depth: false, stencil: false, premultipliedAlpha: true, powerPreference: 'high-performance' });
    if (!gl || gl.isContextLost()) return null;
    try {
      return new WebglRenderer(canvas, gl);
    } catch {
      return null;
    }
  }

  private constructor(
    private readonly canvas: HTMLCanvasElement,
    gl: WebGL2RenderingContext,
  ) {
    super();
    this.gl = gl;
    this.line_program = link(gl, line_vertex, line_fragment);
    this.spot_program = link(gl, spot_vertex, spot_fragment);
    const body = (detail: Detail) => link(gl, body_vertex(detail), body_fragment(detail));
    this.body_programs = { plain: body('plain'), shaped: body('shaped') };
    this.vertices = gl.createBuffer();
    this.indices = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.vertices);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    const stride = words_per_vertex * 4;
    const attribute = (location: number, size: number, type: number, normalised: boolean, offset: number) => {
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, size, type, normalised, stride, offset);
    };
    attribute(0, 2, gl.FLOAT, false, 0);
    attribute(1, 2, gl.FLOAT, false, 8);
    attribute(2, 2, gl.FLOAT, false, 16);
    attribute(3, 4, gl.UNSIGNED_BYTE, true, 24);
    attribute(4, 4, gl.UNSIGNED_BYTE, true, 28);
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  resize(size: Size, pixel_ratio: number): void {
    this.size = size;
    this.ratio = pixel_ratio;
    resize_canvas(this.canvas, size, pixel_ratio);
  }

  end(): void {
    const { gl, colours } = this;
    if (!colours) return;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (this.quads === 0) return;
    if (this.uploaded < this.capacity) this.make_buffers();
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.floats, 0, this.quads * words_per_quad);
    const detail: Detail = this.body.shape_radius > 0 ? 'shaped' : 'plain';
    this.draw(this.line_program, 0, this.bodies_from, colours);
    if (this.spots > 0) {
      this.use(this.spot_program, colours);
      gl.drawArrays(gl.TRIANGLES, this.bodies_from * vertices_per_quad, this.spots * 3);
    } else this.draw(this.body_programs[detail], this.bodies_from, this.bodies_to, colours);
    this.draw(this.line_program, this.bodies_to, this.quads, colours);
  }

  /** Writes the index buffer once, as all quads have the same order of corners. */
  private make_buffers(): void {
    const { gl, capacity } = this;
    const order = new Uint32Array(capacity * 6);
    for (let quad = 0; quad < capacity; quad++) {
      const first = quad * vertices_per_quad;
      order.set([first, first + 1, first + 2, first, first + 2, first + 3], quad * 6);
    }
    gl.bufferData(gl.ARRAY_BUFFER, capacity * words_per_quad * 4, gl.DYNAMIC_DRAW);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, order, gl.STATIC_DRAW);
    this.uploaded = capacity;
  }

  private draw(program: Program, from: number, to: number, colours: Colours): void {
    if (to <= from) return;
    this.use(program, colours);
    this.gl.drawElements(this.gl.TRIANGLES, (to - from) * 6, this.gl.UNSIGNED_INT, from * 24);
  }

  private use({ program, uniforms }: Program, colours: Colours): void {
    const { gl } = this;
    gl.useProgram(program);
    const location = (name: string) => {
      let found = uniforms.get(name);
      if (found === undefined) uniforms.set(name, (found = gl.getUniformLocation(program, name)));
      return found;
    };
    gl.uniform2f(location('u_size'), this.canvas.width, this.canvas.height);
    gl.uniform2f(location('u_half'), this.body.half_length * this.ratio, this.body.half_width * this.ratio);
    gl.uniform1f(location('u_ratio'), this.ratio);
    gl.uniform1f(location('u_shape'), this.body.shape_radius * this.ratio);
    gl.uniform1f(location('u_dim'), this.dim ? 0.45 : 1);
    for (const [name, colour] of [['u_ground', colours.ground], ['u_on_state', colours.on_state], ['u_virtual', colours.virtual], ['u_alarm', colours.alarm]] as const) {
      const value = packed(colour);
      gl.uniform3f(location(name), (value & 0xff) / 255, ((value >> 8) & 0xff) / 255, ((value >> 16) & 0xff) / 255);
    }
  }

  close(): void {
    this.gl.deleteBuffer(this.vertices);
    this.gl.deleteBuffer(this.indices);
    for (const { program } of [this.line_program, this.spot_program, ...Object.values(this.body_programs)]) this.gl.deleteProgram(program);
  }
}

function link(gl: WebGL2RenderingContext, vertex: string, fragment: string): Program {
  const program = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
    const shader = gl.createShader(type);
    if (!shader) throw new Error('no shader');
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? 'shader');
    gl.attachShader(program, shader);
    gl.deleteShader(shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? 'program');
  return { program, uniforms: new Map() };
}
