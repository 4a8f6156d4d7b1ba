#include "host/render/shaders.hpp"

#include <string>
#include <vector>

#include "host/error.hpp"

namespace lockstep {

namespace {

// What all fragments share. Light adds up in linear colours; pictures, the sky and the fog are in sRGB.
const char* const common = R"(#version 300 es
precision highp float;
precision highp sampler2DShadow;
uniform vec3 u_eye, u_to_light;
uniform mat4 u_to_shadow;
uniform sampler2DShadow u_shadow;
uniform float u_texel;     // of the shadow map, in its coordinates
uniform float u_bias;      // m, along the normal
uniform float u_pixel;     // size of a pixel at a distance of 1 m
uniform float u_fog;       // m: where the ground begins to fade
uniform float u_line;      // width of a thin line, in pixels

vec3 sky(float height) {  // sine of the angle above the horizon
  vec3 horizon = vec3(0.885, 0.905, 0.925);
  return height > 0.0 ? mix(horizon, vec3(0.45, 0.59, 0.77), sqrt(height))
                      : mix(horizon, vec3(0.70, 0.71, 0.73), -height);
}

// The share of the sun that arrives: four looks into the shadow map, each of four texels.
float sunlight(vec3 world, vec3 normal) {
  float facing = dot(normal, u_to_light);
  if (facing <= 0.0) return 0.0;
  vec4 p = u_to_shadow * vec4(world + normal * u_bias * (1.0 + 2.0 * sqrt(1.0 - facing * facing)), 1.0);
  if (any(greaterThan(abs(p.xyz), vec3(1.0)))) return 1.0;
  vec3 at = p.xyz * 0.5 + 0.5;
  float a = 1.25 * u_texel, b = 0.5 * u_texel;
  return 0.25 * (texture(u_shadow, at + vec3(a, b, 0.0)) + texture(u_shadow, at + vec3(-b, a, 0.0)) +
                 texture(u_shadow, at - vec3(a, b, 0.0)) + texture(u_shadow, at - vec3(-b, a, 0.0)));
}

// Squares and roots stand for sRGB's curve: they are close to it, and cheap.
vec3 lit(vec3 color, vec3 world, vec3 normal, float gloss) {
  float sun = sunlight(world, normal);
  float facing = max(dot(normal, u_to_light), 0.0);
  vec3 ambient = mix(vec3(0.20, 0.19, 0.18), vec3(0.42, 0.46, 0.52), 0.5 + 0.5 * normal.z);
  vec3 light = color * color * (ambient + sun * facing * vec3(0.80, 0.76, 0.70));
  if (gloss > 0.0) {
    float shine = max(dot(normal, normalize(u_to_light + normalize(u_eye - world))), 0.0);
    shine *= shine, shine *= shine, shine *= shine, shine *= shine, shine *= shine;  // to the power of 32
    light += gloss * sun * shine;
  }
  vec3 bright = max(light - 0.64, 0.0) / 0.36;  // bends: none is cut off at 1
  return sqrt(min(light, 0.64) + 0.36 * bright / (1.0 + bright));
}
)";

const char* const sky_vertex = R"(#version 300 es
precision highp float;
uniform vec3 u_right, u_up, u_into;  // as long as half the picture at a distance of 1
out vec3 v_direction;
void main() {
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  v_direction = u_into + p.x * u_right + p.y * u_up;
  gl_Position = vec4(p, 1.0, 1.0);
}
)";

const char* const sky_fragment = R"(
in vec3 v_direction;
out vec4 color;
void main() { color = vec4(sky(normalize(v_direction).z), 1.0); }
)";

const char* const plane_vertex = R"(#version 300 es
precision highp float;
uniform mat4 u_view_projection;
uniform vec3 u_origin, u_along_x, u_along_y;  // of the plane
uniform vec3 u_center;                        // of what is drawn of it, in its own coordinates
uniform float u_half_size;
out vec3 v_world;
out vec2 v_metres;
void main() {
  v_metres = u_center.xy + u_half_size * vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID / 2 == 0 ? -1.0 : 1.0);
  v_world = u_origin + v_metres.x * u_along_x + v_metres.y * u_along_y;
  gl_Position = u_view_projection * vec4(v_world, 1.0);
}
)";

// A floor fades into the horizon; a wall is a pane of glass, fainter where it is seen from behind.
const char* const plane_fragment = R"(
in vec3 v_world;
in vec2 v_metres;
uniform vec4 u_cuts[8];
uniform int u_cut_count;
uniform vec3 u_normal, u_center_world;
uniform int u_is_floor;
uniform float u_top, u_fade, u_range;  // m: where walls end, upwards, over which height, and sideways
out vec4 color;

// The share of a pixel that lines of this width (in pixels) cover, every `spacing` metres; none where they crowd.
// `footprint`: of the pixel, m.
float lines(float spacing, float width, vec2 footprint) {
  vec2 size = footprint / spacing;
  vec2 away = abs(fract(v_metres / spacing - 0.5) - 0.5) / size;
  vec2 cover = clamp(0.5 * width + 0.5 - away, 0.0, 1.0) * min(width, 1.0) * clamp((0.16 - size) / 0.12, 0.0, 1.0);
  return max(cover.x, cover.y);
}

void main() {
  vec2 footprint = max(fwidth(v_metres), vec2(1e-7));  // while no neighbour has left: there are no derivatives after that
  for (int i = 0; i < u_cut_count; ++i)
    if (dot(u_cuts[i].xyz, v_world) < u_cuts[i].w) discard;
  vec3 sight = v_world - u_eye;
  float distance = length(sight);
  bool behind = dot(sight, u_normal) > 0.0;
  float line = max(0.55 * lines(1.0, u_line, footprint), 0.75 * lines(10.0, 1.8 * u_line, footprint));
  if (min(footprint.x, footprint.y) < 0.016) line = max(line, 0.22 * lines(0.1, 0.8 * u_line, footprint));
  if (u_is_floor != 0) {
    vec3 ground = lit(mix(vec3(0.80, 0.80, 0.79), vec3(0.46, 0.49, 0.53), line), v_world, u_normal, 0.0);
    float fog = 1.0 - exp(-distance * distance / (u_fog * u_fog));
    color = vec4(mix(ground, sky(sight.z / distance), fog), behind ? 0.25 : 1.0);
    return;
  }
  float shown = 1.0 - smoothstep(u_top - u_fade, u_top, v_world.z);
  shown *= 1.0 - smoothstep(0.8 * u_range, u_range, length(v_world - u_center_world));
  color = behind ? vec4(vec3(0.35, 0.40, 0.46), 0.30 * line * shown)
                 : vec4(mix(vec3(0.93, 0.95, 0.97), vec3(0.38, 0.43, 0.50), line), (0.22 + 0.4 * line) * shown);
}
)";

const char* const solid_vertex = R"(#version 300 es
precision highp float;
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 i_position;  // w: the pattern
layout(location = 3) in vec4 i_orientation;
layout(location = 4) in vec4 i_scale;
layout(location = 5) in vec4 i_color;
uniform mat4 u_view_projection;
out vec3 v_world, v_normal, v_local;
flat out vec4 v_color, v_scale;  // v_scale.w: the pattern
vec3 rotate(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
void main() {
  v_local = i_scale.xyz * a_position;
  v_world = i_position.xyz + rotate(i_orientation, v_local);
  v_normal = rotate(i_orientation, a_normal / i_scale.xyz);
  v_color = i_color;
  v_scale = vec4(i_scale.xyz, i_position.w);
  gl_Position = u_view_projection * vec4(v_world, 1.0);
}
)";

// Patterns show how a body is turned: lines along the edges of a box, fields on a ball, wedges on a cylinder.
const char* const solid_fragment = R"(
in vec3 v_world, v_normal, v_local;
flat in vec4 v_color, v_scale;
out vec4 color;
void main() {
  vec3 normal = normalize(v_normal);
  float pixel = u_pixel * length(u_eye - v_world);
  vec3 albedo = v_color.rgb;
  if (v_scale.w == 1.0) {
    vec3 inset = v_scale.xyz - abs(v_local);
    float edge = max(min(inset.x, inset.y), min(max(inset.x, inset.y), inset.z));
    float least = min(v_scale.x, min(v_scale.y, v_scale.z));
    float width = max(0.7 * u_line * pixel, 0.012 * least);
    float line = 1.0 - smoothstep(width - 0.5 * pixel, width + 0.8 * pixel, edge);
    albedo *= 1.0 - 0.38 * line * smoothstep(2.0, 7.0, least / pixel);
  } else if (v_scale.w >= 2.0) {
    vec3 side = clamp(v_local / pixel, -1.0, 1.0);
    float field = side.x * side.y * (v_scale.w == 2.0 ? side.z : 1.0);
    albedo *= 1.0 - 0.13 * (0.5 + 0.5 * field) * smoothstep(2.0, 6.0, v_scale.x / pixel);
  }
  color = vec4(lit(albedo, v_world, normal, 0.10), v_color.a);
}
)";

const char* const empty_fragment = R"(#version 300 es
precision mediump float;
void main() {}
)";

// Marks are read, not lit: a little shade tells which way they are turned.
const char* const mark_fragment = R"(
in vec3 v_world, v_normal, v_local;
flat in vec4 v_color, v_scale;
uniform float u_alpha;
out vec4 color;
void main() {
  float shade = 0.72 + 0.28 * max(dot(normalize(v_normal), normalize(u_eye - v_world)), 0.0);
  color = vec4(v_color.rgb * shade, v_color.a * u_alpha);
}
)";

GLuint compile_shader(const Gl& gl, GLenum kind, const std::string& source) {
  const GLuint shader = gl.CreateShader(kind);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good == GL_TRUE) return shader;
  std::vector<char> log(4096, '\0');
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
  throw Error(Failure::device, "render", std::string("a shader does not compile with this driver\n") + log.data());
}

}  // namespace

Program::Program(const Gl& gl, Shader shader) : gl_(gl), id_(gl.CreateProgram()) {
  std::string vertex, fragment;
  switch (shader) {
    case Shader::sky: vertex = sky_vertex, fragment = std::string(common) + sky_fragment; break;
    case Shader::plane: vertex = plane_vertex, fragment = std::string(common) + plane_fragment; break;
    case Shader::solid: vertex = solid_vertex, fragment = std::string(common) + solid_fragment; break;
    case Shader::shadow: vertex = solid_vertex, fragment = empty_fragment; break;
    case Shader::mark: vertex = solid_vertex, fragment = std::string(common) + mark_fragment; break;
  }
  gl.AttachShader(id_, compile_shader(gl, GL_VERTEX_SHADER, vertex));
  gl.AttachShader(id_, compile_shader(gl, GL_FRAGMENT_SHADER, fragment));
  gl.LinkProgram(id_);
  GLint good = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good == GL_TRUE) return;
  std::vector<char> log(4096, '\0');
  gl.GetProgramInfoLog(id_, static_cast<GLsizei>(log.size() - 1), nullptr, log.data());
  throw Error(Failure::device, "render", std::string("a program does not link with this driver\n") + log.data());
}

void Program::set(const char* name, float value) const { gl_.Uniform1f(gl_.GetUniformLocation(id_, name), value); }
void Program::set(const char* name, int value) const { gl_.Uniform1i(gl_.GetUniformLocation(id_, name), value); }
void Program::set(const char* name, const Eigen::Vector3f& value) const {
  gl_.Uniform3fv(gl_.GetUniformLocation(id_, name), 1, value.data());
}
void Program::set(const char* name, std::span<const Eigen::Vector4f> values) const {
  if (values.empty()) return;
  gl_.Uniform4fv(gl_.GetUniformLocation(id_, name), static_cast<GLsizei>(values.size()), values[0].data());
}
void Program::set(const char* name, const Eigen::Matrix4f& value) const {
  gl_.UniformMatrix4fv(gl_.GetUniformLocation(id_, name), 1, GL_FALSE, value.data());
}

}  // namespace lockstep
