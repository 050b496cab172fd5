#version 460
// Pictures that an engine has rendered, a layer for each individual, as klieg's own: the encoded
// luminance of the object pixels. Reference: cpu::pictures.
#extension GL_GOOGLE_include_directive : require
#define FORMAT r32f
#include "pictures.glsl"
