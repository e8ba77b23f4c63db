/* plane_filter.c for one size of numbers: define NUMBER as their type, NAMED(name) as what a
 * function is called for it, and include this. */

static inline NUMBER NAMED(fold)(NUMBER difference)
{
    const int top = 8 * (int)sizeof(NUMBER) - 1;
    const NUMBER sign = (NUMBER)(0 - (NUMBER)(difference >> top));
    return (NUMBER)((NUMBER)(difference << 1) ^ sign);
}

static inline NUMBER NAMED(unfold)(NUMBER folded)
{
    return (NUMBER)((NUMBER)(folded >> 1) ^ (NUMBER)(0 - (NUMBER)(folded & 1)));
}

/* Filter `count` numbers that another one precedes. The last function needs a row above, too. */
static inline void NAMED(left)(const NUMBER *in, size_t count, NUMBER *restrict out)
{
    for (size_t i = 0; i < count; i++) {
        const NUMBER before = *(in + i - 1);
        out[i] = NAMED(fold)((NUMBER)(in[i] - before));
    }
}

static inline void NAMED(bits)(const NUMBER *in, size_t count, NUMBER *restrict out)
{
    for (size_t i = 0; i < count; i++) {
        const NUMBER before = *(in + i - 1);
        out[i] = (NUMBER)(in[i] ^ before);
    }
}

static inline void NAMED(gradient)(const NUMBER *in, const NUMBER *above, size_t count,
                                   NUMBER *restrict out)
{
    for (size_t i = 0; i < count; i++) {
        const NUMBER own = (NUMBER)(in[i] - above[i]);
        const NUMBER before = (NUMBER)(*(in + i - 1) - *(above + i - 1));
        out[i] = NAMED(fold)((NUMBER)(own - before));
    }
}

/* Filters a row that has another one above it. */
static inline void NAMED(gradient_row)(const NUMBER *in, size_t width, NUMBER *restrict out)
{
    const NUMBER *above = in - width;
    out[0] = NAMED(fold)((NUMBER)(in[0] - above[0]));
    NAMED(gradient)(in + 1, above + 1, width - 1, out + 1);
}

/* Returns the sum of the numbers' bit lengths; of 32 bits each counts by half. */
static inline uint64_t NAMED(count)(const NUMBER *restrict in, size_t end)
{
    int32_t sum = 0;
    for (size_t i = 0; i < end; i++) {
        const int wide = sizeof(NUMBER) == 4;
        const float size = (float)(int32_t)(in[i] >> wide);
        int32_t exponent;
        memcpy(&exponent, &size, sizeof exponent);
        exponent = (exponent >> 23) - 126;
        sum += exponent > 0 ? exponent : 0;
    }
    return (uint64_t)sum;
}

static enum plane_filter NAMED(choose)(const NUMBER *in, size_t width, size_t height)
{
    NUMBER row[LIMIT_TILE_SIDE_PX];
    uint64_t bits[PLANE_FILTER_COUNT] = {0};
    for (size_t y = 1; y < height; y += ROWS_APART) {
        const NUMBER *from = in + y * width;
        bits[PLANE_FILTER_NONE] += NAMED(count)(from, width);
        NAMED(left)(from, width, row);
        bits[PLANE_FILTER_LEFT] += NAMED(count)(row, width);
        NAMED(bits)(from, width, row);
        bits[PLANE_FILTER_XOR] += NAMED(count)(row, width);
        NAMED(gradient_row)(from, width, row);
        bits[PLANE_FILTER_GRADIENT] += NAMED(count)(row, width);
    }
    enum plane_filter best = PLANE_FILTER_NONE;
    for (int k = 1; k < PLANE_FILTER_COUNT; k++)
        if (bits[k] < bits[best]) best = (enum plane_filter)k;
    const uint64_t none = bits[PLANE_FILTER_NONE];
    return bits[best] < none - none / WORTH_PART ? best : PLANE_FILTER_NONE;
}

static void NAMED(apply)(enum plane_filter filter, const NUMBER *restrict in, size_t width,
                         size_t height, NUMBER *restrict out)
{
    const size_t count = width * height, row = filter == PLANE_FILTER_GRADIENT ? width : count;
    if (filter == PLANE_FILTER_NONE) {
        memcpy(out, in, count * sizeof *out);
        return;
    }
    out[0] = filter == PLANE_FILTER_XOR ? in[0] : NAMED(fold)(in[0]);
    if (filter == PLANE_FILTER_XOR)
        NAMED(bits)(in + 1, count - 1, out + 1);
    else
        NAMED(left)(in + 1, row - 1, out + 1);
    for (size_t y = 1; y < height && filter == PLANE_FILTER_GRADIENT; y++)
        NAMED(gradient_row)(in + y * width, width, out + y * width);
}

/* Replaces each number by the sum up to it. */
static inline void NAMED(add_up)(NUMBER *numbers, size_t count)
{
    NUMBER sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum = (NUMBER)(sum + numbers[i]);
        numbers[i] = sum;
    }
}

static void NAMED(undo)(enum plane_filter filter, NUMBER *numbers, size_t width, size_t height)
{
    const size_t count = width * height;
    if (filter == PLANE_FILTER_NONE) return;
    if (filter == PLANE_FILTER_XOR) {
        for (size_t i = 1; i < count; i++) numbers[i] = (NUMBER)(numbers[i] ^ numbers[i - 1]);
        return;
    }
    for (size_t i = 0; i < count; i++) numbers[i] = NAMED(unfold)(numbers[i]);
    if (filter == PLANE_FILTER_LEFT) {
        NAMED(add_up)(numbers, count);
        return;
    }
    for (size_t y = 0; y < height; y++) NAMED(add_up)(numbers + y * width, width);
    for (size_t i = width; i < count; i++) numbers[i] = (NUMBER)(numbers[i] + numbers[i - width]);
}

#undef NUMBER
#undef NAMED
