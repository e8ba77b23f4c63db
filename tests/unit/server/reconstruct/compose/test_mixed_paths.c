/* Mixed pixels of pictures of paths: light of each surface by its share, unless paths know better.
 */
#include <math.h>
#include <string.h>

#include "server/reconstruct/compose/mixed_paths.h"
#include "tests/unit/unit.h"

/* Columns below EDGE show one surface, those after it another or the background; pixels of column
 * EDGE and the one before are mixed. */
enum { WIDTH = 12, HEIGHT = 6, AREA = WIDTH * HEIGHT, EDGE = 6 };

struct scene {
    struct plan plan;
    struct patch patch;
    struct residual_picture picture;
    float depth[AREA], normal[3][AREA], albedo[3][AREA], emission[3][AREA], spp[AREA];
    float radiance[3][AREA], direct[3][AREA], indirect[3][AREA];
    uint32_t id[AREA];
    struct mixed_entry entries[4 * HEIGHT];
};

static void make_plan(struct plan *plan)
{
    *plan = (struct plan){.width_px = WIDTH,
                          .height_px = HEIGHT,
                          .planes = PLANE_BIT(MIXED),
                          .paths = {.without_diffuse_direct = DIRECT_LEFT_LISTED},
                          .camera = {.right = {1, 0, 0},
                                     .up = {0, 1, 0},
                                     .forward = {0, 0, -1},
                                     .half_width = 0.2f,
                                     .half_height = 0.1f}};
}

/* Diffuse light 2 on albedo 1/4 to the left, and 1/8 of light besides; 4 on 1/2 to the right. */
static void fill(struct scene *s, float n, bool background)
{
    for (int i = 0; i < AREA; i++) {
        const bool left = i % WIDTH < EDGE;
        s->depth[i] = left ? 4.0f : background ? 0.0f : 9.0f;
        s->id[i] = left ? 1 : background ? 0 : 2;
        s->spp[i] = n;
        for (int c = 0; c < 3; c++) {
            s->normal[c][i] = c == 2 ? 1.0f : 0.0f;
            s->albedo[c][i] = n * (left ? 0.25f : background ? 0.0f : 0.5f);
            s->direct[c][i] = left ? 1.5f : background ? 0.0f : 4.0f;
            s->indirect[c][i] = left ? 0.5f : 0.0f;
            s->radiance[c][i] = left ? 0.625f : background ? 3.0f : 2.0f;
        }
    }
}

static void list(struct scene *s, float share, bool background)
{
    struct mixed_share *mixed = &s->patch.mixed;
    mixed->entries = s->entries;
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = EDGE - 1; x <= EDGE; x++)
            for (uint32_t lender = EDGE - 1; lender <= EDGE; lender++) {
                struct mixed_entry *e = &mixed->entries[mixed->count];
                const bool left = lender < EDGE;
                const float part = left ? share : background ? 0.0f : 1.0f - share;
                const float albedo = part * (left ? 0.25f : 0.5f);
                *e = (struct mixed_entry){.place = (y * WIDTH + x) * MIXED_SLOTS + MIXED_SLOT_OWN +
                                                   lender - x,
                                          .share = part,
                                          .albedo = {albedo, albedo, albedo}};
                mixed->count++;
            }
}

/* n paths a pixel; the left surface covers so much of mixed pixels, whose paths bring `mean`. */
static void make(struct scene *s, float n, float share, float mean, bool background)
{
    memset(s, 0, sizeof *s);
    make_plan(&s->plan);
    fill(s, n, background);
    s->patch.rect = s->patch.core = s->picture.block = (struct rect){0, 0, WIDTH, HEIGHT};
    s->patch.depth = s->depth;
    s->patch.id = s->id;
    s->patch.paths.spp = s->spp;
    for (int c = 0; c < 3; c++) {
        s->patch.normal[c] = s->normal[c];
        s->patch.path_albedo[c] = s->albedo[c];
        s->patch.path_emission[c] = s->emission[c];
        s->picture.radiance[c] = s->radiance[c];
        s->picture.diffuse_direct[c] = s->direct[c];
        s->picture.diffuse_indirect[c] = s->indirect[c];
        for (int y = 0; y < HEIGHT; y++)
            for (int x = EDGE - 1; x <= EDGE; x++) s->radiance[c][y * WIDTH + x] = mean;
    }
    list(s, share, background);
}

static void apply(struct scene *s)
{
    mixed_paths_apply(&s->plan, &s->patch, s->picture.block, &s->picture);
}

/* Of every pixel: mixed ones have `expected`, others what they had. */
static void expect(const struct scene *s, float expected, bool background)
{
    for (int i = 0; i < AREA; i++) {
        const int x = i % WIDTH;
        const float pure = x < EDGE ? 0.625f : background ? 3.0f : 2.0f;
        const float want = x == EDGE || x == EDGE - 1 ? expected : pure;
        for (int c = 0; c < 3; c++)
            if (!(fabsf(s->radiance[c][i] - want) < 1e-5f))
                fail_msg("%g at column %d, not %g", (double)s->radiance[c][i], x, (double)want);
    }
}

TEST(shares_make_the_pixel)
{
    static struct scene s;
    make(&s, 4, 0.25f, 1.4f, false);
    apply(&s);
    expect(&s, 0.25f * 0.625f + 0.75f * 2.0f, false);
    make(&s, 4, 0.25f, 2.2f, true);
    apply(&s);
    expect(&s, 0.25f * 0.625f + 0.75f * 3.0f, true);
}

/* Where fields bring listed lights alone, entries have the albedo of surfaces that these light,
 * here half of what it is around; others are black there, and have what paths have seen. */
TEST(black_surfaces_have_the_albedo_of_paths)
{
    static struct scene s;
    for (int black = 0; black < 2; black++) {
        make(&s, 4, 0.25f, black ? 1.4f : 0.9f, false);
        for (uint32_t e = 0; e < s.patch.mixed.count; e++)
            for (int c = 0; c < 3; c++) s.entries[e].albedo[c] *= black ? 0.0f : 0.5f;
        apply(&s);
        expect(&s, black ? 0.25f * 0.625f + 0.75f * 2.0f : 0.25f * (0.25f + 0.125f) + 0.75f * 1.0f,
               false);
    }
}

/* The same mean is within the chance of 4 paths, and not of 4096. */
TEST(paths_win_as_they_grow)
{
    static struct scene s;
    float last = 0.0f;
    for (float n = 4; n <= 4096; n *= 4) {
        make(&s, n, 0.5f, 1.7f, false);
        apply(&s);
        const float got = s.radiance[1][EDGE];
        assert_true(got >= last && got <= 1.7f);
        last = got;
    }
    make(&s, 4, 0.5f, 1.7f, false);
    apply(&s);
    expect(&s, 0.5f * (0.625f + 2.0f), false);
    assert_true(last > 1.69f);
}

/* No pixel near by shows one of the surfaces alone. */
TEST(unknown_light_stays_that_of_paths)
{
    static struct scene s;
    make(&s, 4, 0.25f, 1.4f, false);
    for (int i = 0; i < AREA; i++) s.id[i] = i % WIDTH > EDGE ? 7 : s.id[i];
    for (int i = 0; i < AREA; i++) s.depth[i] = i % WIDTH > EDGE ? 90.0f : s.depth[i];
    apply(&s);
    expect(&s, 1.4f, false);
}

/* Paths know more of a lamp's coverage than the list does. */
TEST(lamps_stay_those_of_paths)
{
    static struct scene s;
    make(&s, 4, 0.25f, 1.4f, false);
    for (int i = 0; i < AREA; i++) s.emission[0][i] = i % WIDTH < EDGE ? 4 * 0.1f : 0.0f;
    apply(&s);
    expect(&s, 1.4f, false);
}

TEST(pictures_without_the_list_stay)
{
    static struct scene s;
    make(&s, 4, 0.25f, 1.4f, false);
    s.plan.paths.without_diffuse_direct = DIRECT_LEFT_NONE; /* whole paths: it says nothing */
    apply(&s);
    expect(&s, 1.4f, false);
    make(&s, 4, 0.25f, 1.4f, false);
    s.patch.mixed.count = 0;
    apply(&s);
    expect(&s, 1.4f, false);
    s.plan.planes = 0;
    assert_int_equal(mixed_paths_ring_px(&s.plan), 0);
}
