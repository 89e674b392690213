#pragma once

namespace kantaro::sim {

// GLSL 1.20: MuJoCo 2.2 draws with OpenGL's fixed pipeline and binds no program of its own, so a
// program bound before mjr_render shades every one of its draws. E is OpenGL's eye frame: x right,
// y up, z backward.
inline constexpr const char* kVersion = "#version 120\n";
inline constexpr const char* kVertexShader = R"(
varying vec3 p_E;
varying vec3 normal_E;
varying vec2 texel;
void main() {
  vec4 p = gl_ModelViewMatrix * gl_Vertex;
  p_E = p.xyz;
  normal_E = mat3(gl_ModelViewMatrix) * gl_Normal;
  texel = gl_MultiTexCoord0.xy;
  gl_Position = gl_ProjectionMatrix * p;
}
)";

// Lamps sit a few centimetres apart: each has its own fall-off and shading, while the lobe and the
// highlight are taken for all at their middle, which halves the work. LAMPS is defined before this
// text, so that the loop unrolls.
inline constexpr const char* kLampShader = R"(
varying vec3 p_E;
varying vec3 normal_E;
varying vec2 texel;
uniform sampler2D pattern;   // albedo, slope along texel.x, soil
uniform vec3 p_ELamp[LAMPS];
uniform vec3 p_EMiddle;      // of the lamps
uniform vec3 direction_E;    // of the lamps
uniform float radiance;      // of each lamp at 1 m
uniform float reach;

const vec3 kStain = vec3(0.74, 0.46, 0.23);    // rust and sewage dried on
const vec3 kSludge = vec3(0.26, 0.21, 0.17);

void main() {
  vec3 surface = texture2D(pattern, texel).rgb;
  float albedo = surface.r;
  float gloss = gl_FrontMaterial.specular.r;
  float relief = gl_FrontMaterial.shininess / 128.0;
  // Which way texel.x grows on the wall follows from the screen's derivatives.
  vec3 along = cross(dFdy(p_E), normal_E) * dFdx(texel.x) + cross(normal_E, dFdx(p_E)) * dFdy(texel.x);
  vec3 lean = 2.0 * (surface.g - 128.0 / 255.0) * inversesqrt(max(dot(along, along), 1e-20)) * along;
  vec3 normal = normalize(normal_E - relief * lean);
  vec3 seen = normalize(p_E);
  vec3 to_middle = normalize(p_EMiddle - p_E);

  float diffuse = 0.0;
  float light = 0.0;
  for (int i = 0; i < LAMPS; ++i) {
    vec3 to_lamp = p_ELamp[i] - p_E;
    float fall_off = 1.0 / dot(to_lamp, to_lamp);
    // The bright tube sends light round corners: a little arrives from everywhere.
    diffuse += fall_off * (0.92 * sqrt(fall_off) * max(dot(normal, to_lamp), 0.0) + 0.08);
    light += fall_off;
  }
  float highlight = max(dot(reflect(seen, normal), to_middle), 0.0);
  highlight *= highlight; highlight *= highlight; highlight *= highlight;
  // LEDs behind a diffuser: brightest to the front, some light to the sides, none backward.
  float lobe = max(0.0, 0.25 - 0.75 * dot(to_middle, direction_E));
  float fade = clamp(1.0 + p_E.z / reach, 0.0, 1.0);
  float sludge = max(2.0 * surface.b - 1.0, 0.0);
  vec3 tint = mix(mix(vec3(1.0), kStain, min(2.0 * surface.b, 1.0)), kSludge, sludge);
  vec3 sent = gl_FrontMaterial.diffuse.rgb * tint * (albedo * diffuse) + gloss * (0.3 + sludge) * highlight * light;
#ifdef FILM
  // Drops and runs stand out more than the wall below them, and mirror the lamps sharply.
  vec3 drop = normalize(normal_E - 2.0 * lean);
  float spark = max(dot(reflect(seen, drop), to_middle), 0.0);
  spark *= spark; spark *= spark; spark *= spark; spark *= spark; spark *= spark;
  sent += gl_FrontMaterial.emission.r / max(gl_FrontMaterial.diffuse.r, 0.01) * spark * light;
#endif
  gl_FragColor = vec4(sqrt(1.0 - exp(-radiance * lobe * fade * sent)), 1.0);
}
)";

// Water, drawn over the finished frame. What shows through it is the frame itself, looked up where
// the bent ray meets the bed; what it mirrors is the frame where the mirrored ray meets the wall
// around, taken as round, or that wall's plain shade where the frame does not show it.
// texel: wall_axis is gl_MultiTexCoord0, p_VAxis gl_MultiTexCoord1, along and left
// gl_MultiTexCoord2.
inline constexpr const char* kWaterVertexShader = R"(
varying vec3 p_E;
varying vec3 normal_E;
varying vec3 axis_E;
varying vec3 to_axis_E;
varying vec2 place;
void main() {
  mat3 R_EW = mat3(gl_ModelViewMatrix);
  vec4 p = gl_ModelViewMatrix * gl_Vertex;
  p_E = p.xyz;
  normal_E = R_EW * gl_Normal;
  axis_E = R_EW * gl_MultiTexCoord0.xyz;
  to_axis_E = R_EW * gl_MultiTexCoord1.xyz;
  place = gl_MultiTexCoord2.xy;
  gl_Position = gl_ProjectionMatrix * p;
}
)";
inline constexpr const char* kWaterShader = R"(
varying vec3 p_E;
varying vec3 normal_E;
varying vec3 axis_E;
varying vec3 to_axis_E;
varying vec2 place;          // along the way and left of it [m]
uniform sampler2D frame;     // what was drawn so far, as displayed
uniform vec2 frame_share;    // of the texture that the frame fills
uniform vec3 p_ELamp[LAMPS];
uniform vec3 p_EMiddle;
uniform vec3 direction_E;
uniform float radiance;
uniform float reach;
uniform float wall_radius;
uniform float bed_radius;
uniform float depth;         // over the invert

const float kIndex = 1.33;
const vec3 kAbsorbed = vec3(12.0, 14.0, 18.0);   // per metre: grey water, a little brown
const vec3 kMurk = vec3(0.055, 0.048, 0.035);    // what a deep layer sends back

// Where the frame shows a point: 0 to 1 across it.
vec2 Place(vec3 p) {
  vec4 clip = gl_ProjectionMatrix * vec4(p, 1.0);
  return 0.5 + 0.5 * clip.xy / max(clip.w, 0.001);
}

vec3 Shown(vec2 at) {
  vec3 c = min(texture2D(frame, clamp(at, 0.002, 0.998) * frame_share).rgb, 0.996);
  return -log(1.0 - c * c);
}

// 1 where the frame shows a point at this place, fading to 0 at its rim.
float InFrame(vec2 at, float z) {
  vec2 inside = 1.0 - abs(2.0 * at - 1.0);
  return step(z, -0.03) * smoothstep(0.0, 0.08, min(inside.x, inside.y));
}

float Lobe(vec3 to_middle) { return max(0.0, 0.25 - 0.75 * dot(to_middle, direction_E)); }

// Light that arrives at a point of a surface from all lamps, as if from their middle.
float Arriving(vec3 p, vec3 normal) {
  vec3 to_middle = p_EMiddle - p;
  float fall_off = 1.0 / dot(to_middle, to_middle);
  to_middle *= sqrt(fall_off);
  float fade = clamp(1.0 + p.z / reach, 0.0, 1.0);
  return float(LAMPS) * radiance * Lobe(to_middle) * fade * fall_off *
         (0.92 * max(dot(normal, to_middle), 0.0) + 0.08);
}

// A sine to the eye, of parabolas, which cost a fraction.
float Wave(float turns) {
  float x = 2.0 * fract(turns) - 1.0;
  return 4.0 * x * (1.0 - abs(x));
}

// Slopes of slow, shallow ripples; they blur with distance, where a pixel holds many.
vec2 Ripples(vec2 at) {
  vec2 slope = 0.007 * vec2(0.9, 0.45) * Wave(dot(at, vec2(17.5, 8.8)) + 0.32 * Wave(1.1 * at.x))
             + 0.005 * vec2(0.8, -0.6) * Wave(dot(at, vec2(30.2, -22.3)) + 0.24 * Wave(2.1 * at.x + 0.2))
             + 0.004 * vec2(0.3, 0.95) * Wave(dot(at, vec2(15.1, 49.3)) + 0.5)
             + 0.010 * vec2(1.0, 0.1) * Wave(dot(at, vec2(6.0, 1.0)));
  return slope / (1.0 + 0.8 * p_E.z * p_E.z);
}

void main() {
  vec3 up = normalize(normal_E);
  vec3 seen = normalize(p_E);
  vec3 left = normalize(cross(up, axis_E) + 0.0001 * dFdx(p_E));
  vec3 along = cross(left, up);
  vec2 slope = Ripples(place);
  vec3 normal = normalize(up - slope.x * along - slope.y * left);
  float facing = clamp(-dot(seen, normal), 0.02, 1.0);
  float grazing = (1.0 - facing) * (1.0 - facing);
  float mirrors = 0.02 + 0.98 * grazing * grazing * (1.0 - facing);

  vec3 mirrored = reflect(seen, normal);
  mirrored += max(0.0, 0.02 - dot(mirrored, up)) * up;
  vec3 from_axis = -to_axis_E - axis_E * dot(-to_axis_E, axis_E);
  vec3 across = mirrored - axis_E * dot(mirrored, axis_E);
  float a = max(dot(across, across), 1e-4);
  float b = dot(from_axis, across);
  float c = dot(from_axis, from_axis) - wall_radius * wall_radius;
  float way = (sqrt(max(b * b - a * c, 0.0)) - b) / a;
  vec3 wall = p_E + way * mirrored;
  vec3 plain = vec3(0.42, 0.38, 0.32) * Arriving(wall, -normalize(from_axis + way * across));
  vec2 wall_place = Place(wall);
  vec3 mirror = mix(plain, Shown(wall_place), InFrame(wall_place, wall.z));

  vec3 bent = refract(seen, normal, 1.0 / kIndex);
  float under = max(depth - place.y * place.y / (2.0 * bed_radius), 0.0);
  float path = under / max(-dot(bent, up), 0.3);
  vec3 through = exp(-kAbsorbed * (path + under));
  vec3 bottom = p_E + path * bent;
  vec2 bed_place = Place(bottom);
  vec3 bed = Shown(mix(Place(p_E), bed_place, InFrame(bed_place, bottom.z)));
  vec3 murk = kMurk * Arriving(p_E, up) * (1.0 - through);

  // The lamps themselves, mirrored: sharp, and drawn out by the ripples.
  float glint = 0.0;
  for (int i = 0; i < LAMPS; ++i) {
    vec3 to_lamp = p_ELamp[i] - p_E;
    float fall_off = 1.0 / dot(to_lamp, to_lamp);
    // Of cos^300, which takes a logarithm and an exponential, the like.
    float spot = 1.0 / (1.0 + 37.5 * (1.0 - sqrt(fall_off) * dot(mirrored, to_lamp)));
    spot *= spot; spot *= spot;
    glint += fall_off * spot * spot;
  }
  glint *= radiance * Lobe(normalize(p_EMiddle - p_E));
  vec3 sent = (1.0 - mirrors) * (bed * through + murk) + mirrors * (mirror + 40.0 * glint);
  gl_FragColor = vec4(sqrt(1.0 - exp(-sent)), 1.0);
}
)";

// Depth as 24 bits over twice the reach, independent of how MuJoCo sets up its depth buffer.
inline constexpr const char* kDepthShader = R"(
varying vec3 p_E;
uniform float reach;
void main() {
  float depth = -p_E.z / (2.0 * reach) * 255.0;
  float high = floor(depth);
  float middle = floor((depth - high) * 256.0);
  float low = floor((depth - high - middle / 256.0) * 65536.0);
  gl_FragColor = vec4(high / 255.0, middle / 255.0, low / 255.0, 1.0);
}
)";

}  // namespace kantaro::sim
