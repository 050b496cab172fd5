// A generation in two kernels. `measure` shades a tile of the picture for one individual after the other and
// measures it, `judge` adds the tiles up and makes the score. Compiled for one number of lights: -DLIGHTS=n.
//
// A tile with its border is 32 x 32 pixels, so that a row is a warp; a thread has ROWS of them, one below the other,
// whose surface stays in its registers. The picture of an individual never leaves shared memory.

constexpr int SIDE = 32;           // of a tile with its border of one pixel
constexpr int ROWS = 4;            // of a warp
constexpr int WARPS = SIDE / ROWS; // of a block
constexpr int THREADS = 32 * WARPS;
constexpr int AREA = SIDE * SIDE;
constexpr int BINS = 32;
constexpr int MOST = 32; // individuals of a block
constexpr unsigned ALL = 0xffffffffu;

// Flags of a pixel: a shaded one, and what it counts as; a tile's border counts as nothing.
constexpr int OBJECT = 1, SURFACE = 2, EDGE = 4, COUNTED = SURFACE | EDGE;

struct Pixel {
    float3 p, n, v;  // position, normal, direction to the viewer
    float n_v;       // n . v
    float lobe;      // half the Blinn-Phong exponent
    float diffuse, specular, unlit;
    int flags;
};

__device__ float dot(float3 a, float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// The sRGB encoding (IEC 61966-2-1), of a value from 0 on.
__device__ float encode(float x) {
    x = fminf(x, 1.0f);
    return x <= 0.0031308f ? 12.92f * x : 1.055f * __powf(x, 1.0f / 2.4f) - 0.055f;
}

// A pixel's surface is four records, of which those of a tile stand side by side.
__device__ Pixel load(const float4* tile, int pixel) {
    float4 a = tile[pixel], b = tile[AREA + pixel], c = tile[2 * AREA + pixel], d = tile[3 * AREA + pixel];
    Pixel at;
    at.p = make_float3(a.x, a.y, a.z);
    at.lobe = a.w;
    at.n = make_float3(b.x, b.y, b.z);
    at.diffuse = b.w;
    at.v = make_float3(c.x, c.y, c.z);
    at.specular = c.w;
    at.n_v = dot(at.n, at.v);
    at.unlit = d.x;
    at.flags = int(d.y);
    return at;
}

// Adds what a light does to a thread's pixels. It costs a warp little where it reaches none of them.
__device__ void add_light(float4 place, float2 strength, const Pixel (&at)[ROWS], float (&radiance)[ROWS]) {
    float3 l[ROWS];
    float inverse[ROWS], n_l[ROWS];
    bool reached = false;
#pragma unroll
    for (int k = 0; k < ROWS; ++k) {
        l[k] = make_float3(place.x - at[k].p.x, place.y - at[k].p.y, place.z - at[k].p.z);
        inverse[k] = rsqrtf(dot(l[k], l[k]));
        n_l[k] = dot(at[k].n, l[k]) * inverse[k];
        reached |= n_l[k] > 0.0f;
    }
    if (!__any_sync(ALL, reached)) {
        return;
    }
#pragma unroll
    for (int k = 0; k < ROWS; ++k) {
        // (n . h)^2 without h: |l + v|^2 = 2 + 2 l . v.
        float along = fmaxf(n_l[k] + at[k].n_v, 0.0f);
        float whole = fmaxf(2.0f + 2.0f * dot(at[k].v, l[k]) * inverse[k], 1e-20f);
        float n_h2 = fminf(__fdividef(along * along, whole), 1.0f);
        float lobe = __powf(n_h2, at[k].lobe);
        float falloff = place.w * inverse[k] * inverse[k];
        float both = strength.x * at[k].diffuse + strength.y * at[k].specular * lobe;
        radiance[k] += n_l[k] > 0.0f ? falloff * n_l[k] * both : 0.0f;
    }
}

// The sum of each of four values over a warp: lanes 0, 8, 16 and 24 get that of x, y, z and w.
__device__ float sum4(float4 x, int lane) {
    bool upper = lane & 16, second = lane & 8;
    float a = (upper ? x.z : x.x) + __shfl_xor_sync(ALL, upper ? x.x : x.z, 16);
    float b = (upper ? x.w : x.y) + __shfl_xor_sync(ALL, upper ? x.y : x.w, 16);
    float sum = (second ? b : a) + __shfl_xor_sync(ALL, second ? a : b, 8);
    sum += __shfl_xor_sync(ALL, sum, 4);
    sum += __shfl_xor_sync(ALL, sum, 2);
    return sum + __shfl_xor_sync(ALL, sum, 1);
}

// A tap outside the object takes the centre's value.
__device__ float tap(float value, float centre) { return value < 0.0f ? centre : value; }

// Length of the Sobel pair of three rows.
__device__ float slope(const float (&t)[3], const float (&m)[3], const float (&b)[3]) {
    float c = m[1];
    float tl = tap(t[0], c), tm = tap(t[1], c), tr = tap(t[2], c), ml = tap(m[0], c), mr = tap(m[2], c);
    float bl = tap(b[0], c), bm = tap(b[1], c), br = tap(b[2], c);
    float x = (tr - tl) + 2.0f * (mr - ml) + (br - bl);
    float y = (bl - tl) + 2.0f * (bm - tm) + (br - tr);
    return sqrtf(x * x + y * y) * 0.125f;
}

// `lights` is six floats for each: x, y, z, squared distance from the centre, diffuse and specular intensity.
// `bins` and `sums` get an entry for each individual and tile; sums are of I - 1/2, its square, |grad I| over SURFACE
// and the edges' contrast.
extern "C" __global__ void __launch_bounds__(THREADS, 2)
measure(const float4* surface, const float* lights, int population, int individuals, float per_contrast,
        unsigned* bins, float4* sums) {
    __shared__ float frames[2][SIDE][SIDE]; // one is written while the other is read
    __shared__ float4 places[MOST * LIGHTS];
    __shared__ float2 strengths[MOST * LIGHTS];
    __shared__ unsigned counts[MOST][BINS];
    __shared__ float parts[MOST][WARPS][4];

    int thread = threadIdx.x, lane = thread % 32, warp = thread / 32, top = warp * ROWS;
    int first = blockIdx.y * individuals;
    int here = min(individuals, population - first);
    for (int i = thread; i < here * LIGHTS; i += THREADS) {
        const float* light = lights + (first * LIGHTS + i) * 6;
        places[i] = make_float4(light[0], light[1], light[2], light[3]);
        strengths[i] = make_float2(light[4], light[5]);
    }
    for (int i = thread; i < here * BINS; i += THREADS) {
        counts[i / BINS][i % BINS] = 0;
    }
    Pixel at[ROWS];
    int flags = 0;
#pragma unroll
    for (int k = 0; k < ROWS; ++k) {
        at[k] = load(surface + blockIdx.x * 4 * AREA, (top + k) * SIDE + lane);
        flags |= at[k].flags;
    }
    bool any_object = __any_sync(ALL, flags & OBJECT), any_counted = __any_sync(ALL, flags & COUNTED);
    int left = max(lane - 1, 0), right = min(lane + 1, SIDE - 1);
    __syncthreads();

    for (int i = 0; i < here; ++i) {
        float (*frame)[SIDE] = frames[i & 1];
        float radiance[ROWS];
#pragma unroll
        for (int k = 0; k < ROWS; ++k) {
            radiance[k] = at[k].unlit;
        }
        if (any_object) {
#pragma unroll
            for (int l = 0; l < LIGHTS; ++l) {
                add_light(places[i * LIGHTS + l], strengths[i * LIGHTS + l], at, radiance);
            }
        }
#pragma unroll
        for (int k = 0; k < ROWS; ++k) {
            frame[top + k][lane] = at[k].flags & OBJECT ? encode(radiance[k]) : -1.0f;
        }
        __syncthreads();
        float4 sum = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
        if (any_counted) {
            float rows[3][3]; // above, of and below a pixel; which is which turns round
            int above = max(top - 1, 0);
            rows[0][0] = frame[above][left], rows[0][1] = frame[above][lane], rows[0][2] = frame[above][right];
            rows[1][0] = frame[top][left], rows[1][1] = frame[top][lane], rows[1][2] = frame[top][right];
#pragma unroll
            for (int k = 0; k < ROWS; ++k) {
                int next = min(top + k + 1, SIDE - 1);
                float (&below)[3] = rows[(k + 2) % 3];
                below[0] = frame[next][left], below[1] = frame[next][lane], below[2] = frame[next][right];
                if (at[k].flags & COUNTED) {
                    float centre = rows[(k + 1) % 3][1];
                    float steep = slope(rows[k % 3], rows[(k + 1) % 3], below);
                    float distance = centre - 0.5f;
                    sum.x += distance;
                    sum.y += distance * distance;
                    sum.z += at[k].flags & SURFACE ? steep : 0.0f;
                    sum.w += at[k].flags & EDGE ? fminf(steep * per_contrast, 1.0f) : 0.0f;
                    atomicAdd(&counts[i][min(int(centre * float(BINS)), BINS - 1)], 1u);
                }
            }
        }
        float total = sum4(sum, lane);
        if (lane % 8 == 0) {
            parts[i][warp][lane / 8] = total;
        }
    }
    __syncthreads();
    for (int i = thread; i < here * BINS; i += THREADS) {
        bins[((first + i / BINS) * gridDim.x + blockIdx.x) * BINS + i % BINS] = counts[i / BINS][i % BINS];
    }
    for (int i = thread; i < here; i += THREADS) {
        float4 sum = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
        for (int w = 0; w < WARPS; ++w) {
            sum.x += parts[i][w][0], sum.y += parts[i][w][1], sum.z += parts[i][w][2], sum.w += parts[i][w][3];
        }
        sums[(first + i) * gridDim.x + blockIdx.x] = sum;
    }
}

// The terms edge, mean, grad, var and hist of each individual, and their weighted sum; a block for each.
// `constants`: SURFACE and EDGE pixels, the normals' mean gradient, the target of the mean, and the five weights.
extern "C" __global__ void __launch_bounds__(THREADS)
judge(const unsigned* bins, const float4* sums, int tiles, const float* constants, float* terms, float* scores) {
    __shared__ unsigned counts[WARPS][BINS];
    __shared__ float parts[WARPS][4];
    int thread = threadIdx.x, lane = thread % 32, warp = thread / 32, individual = blockIdx.x;
    unsigned count = 0;
    for (int t = warp; t < tiles; t += WARPS) {
        count += bins[(individual * tiles + t) * BINS + lane];
    }
    counts[warp][lane] = count;
    float4 sum = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int t = thread; t < tiles; t += THREADS) {
        float4 part = sums[individual * tiles + t];
        sum.x += part.x, sum.y += part.y, sum.z += part.z, sum.w += part.w;
    }
    float total = sum4(sum, lane);
    if (lane % 8 == 0) {
        parts[warp][lane / 8] = total;
    }
    __syncthreads();
    if (warp != 0) {
        return;
    }
    float surface = constants[0], edges = constants[1], objects = surface + edges;
    float of[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    count = 0;
    for (int w = 0; w < WARPS; ++w) {
        count += counts[w][lane];
        for (int k = 0; k < 4; ++k) {
            of[k] += parts[w][k];
        }
    }
    float share = float(count) / objects;
    float entropy = sum4(make_float4(count ? -share * logf(share) : 0.0f, 0.0f, 0.0f, 0.0f), lane);
    if (lane != 0) {
        return;
    }
    float distance = of[0] / objects;
    float variance = fmaxf(of[1] / objects - distance * distance, 0.0f);
    float target = constants[3];
    float* term = terms + individual * 5;
    term[0] = edges > 0.0f ? 1.0f - of[3] / edges : 0.0f;
    term[1] = fabsf(0.5f + distance - target) / fmaxf(target, 1.0f - target);
    term[2] = constants[2] < 1e-6f ? 0.0f : 1.0f - fminf(of[2] / fmaxf(surface, 1.0f) / constants[2], 1.0f);
    term[3] = 1.0f - fminf(sqrtf(variance * 12.0f), 1.0f);
    term[4] = 1.0f - entropy / logf(float(BINS));
    float score = 0.0f;
    for (int k = 0; k < 5; ++k) {
        score += constants[4 + k] * term[k];
    }
    scores[individual] = score;
}
