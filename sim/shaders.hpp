#pragma once

namespace kantaro::sim {

// GLSL 1.30 with the fixed pipeline's matrices and materials: MuJoCo 2.2 draws with that and binds
// no program of its own, so a program bound before mjr_render shades every one of its draws. E is
// OpenGL's eye frame: x right, y up, z backward. LAMPS and REACH are defined before these texts.
//
// What is the same all over a draw comes to the fragments as flat inputs: llvmpipe reads a uniform
// there once for each pixel, bounds check and all, which took half of the time.
inline constexpr const char* kVersion = "#version 130\n";
inline constexpr const char* kVertexShader = R"(
uniform vec3 p_ELamp[LAMPS];
uniform vec3 direction_E;    // of the lamps
uniform float radiance;      // of each lamp at 1 m
out vec3 p_E;
out vec3 normal_E;
out vec2 texel;
flat out vec3 lamp[LAMPS];
flat out vec3 ahead;
flat out vec3 clean;         // colour, and what stains and sludge add to it
flat out vec3 stained;
flat out vec3 sludged;
flat out vec4 look;          // gloss, relief, film, light

const vec3 kStain = vec3(0.74, 0.46, 0.23);    // rust and sewage dried on
const vec3 kSludge = vec3(0.26, 0.21, 0.17);

void main() {
  vec4 p = gl_ModelViewMatrix * gl_Vertex;
  p_E = p.xyz;
  normal_E = mat3(gl_ModelViewMatrix) * gl_Normal;
  texel = gl_MultiTexCoord0.xy;
  gl_Position = gl_ProjectionMatrix * p;
  lamp = p_ELamp;
  ahead = direction_E;
  clean = gl_FrontMaterial.diffuse.rgb;
  stained = clean * (kStain - 1.0);
  sludged = clean * (kSludge - kStain);
  look = vec4(gl_FrontMaterial.specular.r, gl_FrontMaterial.shininess / 128.0,
              gl_FrontMaterial.emission.r / max(clean.r, 0.01), radiance);
}
)";

// Lamps have their own fall-off and shading each, while the lobe and the highlight are taken for
// all at their middle. Lengths are divided by as late as can be, as divisions and roots are what
// takes time.
inline constexpr const char* kLampShader = R"(
in vec3 p_E;
in vec3 normal_E;
in vec2 texel;
flat in vec3 lamp[LAMPS];
flat in vec3 ahead;
flat in vec3 clean;
flat in vec3 stained;
flat in vec3 sludged;
flat in vec4 look;
uniform sampler2D pattern;   // albedo, slope along texel.x, soil; its rows run round the wall

void main() {
  vec3 surface = texture(pattern, texel.yx).rgb;
  // Which way texel.x grows on the wall follows from the screen's derivatives.
  vec3 along = cross(dFdy(p_E) * dFdx(texel.x) - dFdx(p_E) * dFdy(texel.x), normal_E);
  vec3 lean = (2.0 * surface.g - 256.0 / 255.0) * inversesqrt(max(dot(along, along), 1e-20)) * along;
  vec3 normal = normal_E - look.y * lean;
  vec3 middle = vec3(0.0);
  for (int i = 0; i < LAMPS; ++i) middle += lamp[i];
  vec3 to_middle = middle * (1.0 / float(LAMPS)) - p_E;

  float normal2 = dot(normal, normal);
  float away2 = dot(p_E, p_E);
  float both = 1.0 / (normal2 * away2);
  float upright2 = both * away2;  // 1 / normal2
  float upright = sqrt(upright2);
  float nearness2 = 1.0 / dot(to_middle, to_middle);
  float nearness = sqrt(nearness2);

  float diffuse = 0.0;
  float light = 0.0;
  for (int i = 0; i < LAMPS; ++i) {
    vec3 to_lamp = lamp[i] - p_E;
    float fall_off = 1.0 / dot(to_lamp, to_lamp);
    // The bright tube sends light round corners: a little arrives from everywhere.
    diffuse += fall_off * (0.92 * upright * sqrt(fall_off) * max(dot(normal, to_lamp), 0.0) + 0.08);
    light += fall_off;
  }
  // The cosine of p_E, mirrored, and to_middle, to the 8th.
  float unit2 = both * normal2 * nearness2;
  float straight = dot(p_E, to_middle);
  float highlight =
      max(straight - 2.0 * upright2 * dot(normal, to_middle) * dot(normal, p_E), 0.0);
  highlight *= highlight * unit2; highlight *= highlight; highlight *= highlight;
  // LEDs behind a diffuser: brightest to the front, some light to the sides, none backward.
  float lobe = max(0.0, 0.25 - 0.75 * nearness * dot(to_middle, ahead));
  float fade = max(1.0 + p_E.z * (1.0 / REACH), 0.0);
  float stain = min(2.0 * surface.b, 1.0);
  float sludge = 2.0 * surface.b - stain;
  float shine = look.x * (0.3 + sludge) * highlight;
#ifdef FILM
  // Drops and runs stand out more than the wall below them, and mirror the lamps sharply.
  vec3 drop = normal_E - 2.0 * lean;
  float spark =
      max(straight - 2.0 * dot(drop, to_middle) * dot(drop, p_E) / dot(drop, drop), 0.0);
  spark *= spark * unit2; spark *= spark; spark *= spark; spark *= spark; spark *= spark;
  shine += look.z * spark;
#endif
  vec3 colour = clean + stained * stain + sludged * sludge;
  float exposed = -look.w * lobe * fade;
  gl_FragColor = vec4(
      sqrt(1.0 - exp(colour * (exposed * surface.r * diffuse) + exposed * light * shine)), 1.0);
}
)";

// Water, drawn over the finished frame. What shows through it is the frame itself, looked up where
// the bent ray meets the bed; what it mirrors is the frame where the mirrored ray meets the wall
// around, taken as round, or that wall's plain shade where the frame does not show it.
// texel: wall_axis is gl_MultiTexCoord0, p_VAxis gl_MultiTexCoord1, along and left
// gl_MultiTexCoord2.
inline constexpr const char* kWaterVertexShader = R"(
uniform vec2 frame_share;    // of the texture that the frame fills
uniform vec3 p_ELamp[LAMPS];
uniform vec3 direction_E;
uniform float radiance;
uniform vec3 bed;            // radius of the wall around, radius of the invert, depth over it
out vec3 p_E;
out vec3 normal_E;
out vec3 axis_E;
out vec3 to_axis_E;
out vec2 place;              // along the way and left of it [m]
flat out vec3 lamp[LAMPS];
flat out vec4 ahead_light;   // direction of the lamps, and radiance
flat out vec4 projection;    // what of it takes x, y and twice z
flat out vec2 share;
flat out vec3 section;       // bed
void main() {
  mat3 R_EW = mat3(gl_ModelViewMatrix);
  vec4 p = gl_ModelViewMatrix * gl_Vertex;
  p_E = p.xyz;
  normal_E = R_EW * gl_Normal;
  axis_E = R_EW * gl_MultiTexCoord0.xyz;
  to_axis_E = R_EW * gl_MultiTexCoord1.xyz;
  place = gl_MultiTexCoord2.xy;
  gl_Position = gl_ProjectionMatrix * p;
  lamp = p_ELamp;
  ahead_light = vec4(direction_E, radiance);
  projection = vec4(gl_ProjectionMatrix[0].x, gl_ProjectionMatrix[1].y, gl_ProjectionMatrix[2].xy);
  share = frame_share;
  section = bed;
}
)";
inline constexpr const char* kWaterShader = R"(
in vec3 p_E;
in vec3 normal_E;
in vec3 axis_E;
in vec3 to_axis_E;
in vec2 place;
flat in vec3 lamp[LAMPS];
flat in vec4 ahead_light;
flat in vec4 projection;
flat in vec2 share;
flat in vec3 section;
uniform sampler2D frame;     // what was drawn so far, as displayed

const float kIndex = 1.33;
const vec3 kAbsorbed = vec3(12.0, 14.0, 18.0);   // per metre: grey water, a little brown
const vec3 kMurk = vec3(0.055, 0.048, 0.035);    // what a deep layer sends back

// Where the frame shows a point: 0 to 1 across it.
vec2 Place(vec3 p) {
  return 0.5 + 0.5 * (projection.xy * p.xy + projection.zw * p.z) / max(-p.z, 0.001);
}

vec3 Shown(vec2 at) {
  vec3 c = min(texture(frame, clamp(at, 0.002, 0.998) * share).rgb, 0.996);
  return -log(1.0 - c * c);
}

// 1 where the frame shows a point at this place, fading to 0 at its rim.
float InFrame(vec2 at, float z) {
  vec2 inside = 1.0 - abs(2.0 * at - 1.0);
  return step(z, -0.03) * smoothstep(0.0, 0.08, min(inside.x, inside.y));
}

vec3 Middle() {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < LAMPS; ++i) sum += lamp[i];
  return sum * (1.0 / float(LAMPS));
}

float Lobe(vec3 to_middle) { return max(0.0, 0.25 - 0.75 * dot(to_middle, ahead_light.xyz)); }

// Light that arrives at a point of a surface from all lamps, as if from their middle.
float Arriving(vec3 p, vec3 normal) {
  vec3 to_middle = Middle() - p;
  float fall_off = 1.0 / dot(to_middle, to_middle);
  to_middle *= sqrt(fall_off);
  float fade = max(1.0 + p.z * (1.0 / REACH), 0.0);
  return float(LAMPS) * ahead_light.w * Lobe(to_middle) * fade * fall_off *
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
  float c = dot(from_axis, from_axis) - section.x * section.x;
  float way = (sqrt(max(b * b - a * c, 0.0)) - b) / a;
  vec3 wall = p_E + way * mirrored;
  vec3 plain = vec3(0.42, 0.38, 0.32) * Arriving(wall, -normalize(from_axis + way * across));
  vec2 wall_place = Place(wall);
  vec3 mirror = mix(plain, Shown(wall_place), InFrame(wall_place, wall.z));

  vec3 bent = refract(seen, normal, 1.0 / kIndex);
  float under = max(section.z - place.y * place.y / (2.0 * section.y), 0.0);
  float path = under / max(-dot(bent, up), 0.3);
  vec3 through = exp(-kAbsorbed * (path + under));
  vec3 bottom = p_E + path * bent;
  vec2 bed_place = Place(bottom);
  vec3 bed = Shown(mix(Place(p_E), bed_place, InFrame(bed_place, bottom.z)));
  vec3 murk = kMurk * Arriving(p_E, up) * (1.0 - through);

  // The lamps themselves, mirrored: sharp, and drawn out by the ripples.
  float glint = 0.0;
  for (int i = 0; i < LAMPS; ++i) {
    vec3 to_lamp = lamp[i] - p_E;
    float fall_off = 1.0 / dot(to_lamp, to_lamp);
    // Of cos^300, which takes a logarithm and an exponential, the like.
    float spot = 1.0 / (1.0 + 37.5 * (1.0 - sqrt(fall_off) * dot(mirrored, to_lamp)));
    spot *= spot; spot *= spot;
    glint += fall_off * spot * spot;
  }
  glint *= ahead_light.w * Lobe(normalize(Middle() - p_E));
  vec3 sent = (1.0 - mirrors) * (bed * through + murk) + mirrors * (mirror + 40.0 * glint);
  gl_FragColor = vec4(sqrt(1.0 - exp(-sent)), 1.0);
}
)";

// Depth as 24 bits over twice the reach, independent of how MuJoCo sets up its depth buffer.
inline constexpr const char* kDepthVertexShader = R"(
out vec3 p_E;
void main() {
  vec4 p = gl_ModelViewMatrix * gl_Vertex;
  p_E = p.xyz;
  gl_Position = gl_ProjectionMatrix * p;
}
)";
inline constexpr const char* kDepthShader = R"(
in vec3 p_E;
void main() {
  float depth = -p_E.z / (2.0 * REACH) * 255.0;
  float high = floor(depth);
  float middle = floor((depth - high) * 256.0);
  float low = floor((depth - high - middle / 256.0) * 65536.0);
  gl_FragColor = vec4(high / 255.0, middle / 255.0, low / 255.0, 1.0);
}
)";

}  // namespace kantaro::sim
