/* Where light fields bring what diffuse lobes send on, and paths the rest: what both add up to, and
 * pixels that need no path. */
#include "tests/unit/worker/trace/field/lobe_division.h"

/* -- energy -- */

enum view { FROM_ABOVE, GRAZING };

/* Beyond glTF's core. */
enum layer { BARE, COAT, SHEEN, LEAF, FILM };

struct division {
    uint32_t light; /* enum light_type */
    float roughness, metallic, transmission;
    enum layer layer;
    enum view view;
};

static void add_light(struct plan *p, uint32_t type)
{
    if (type == LIGHT_RECTANGLE) {
        fixture_ceiling_light(p, 0.5f, 2.0f, -0.5f, 0.7f, 8);
        return;
    }
    struct plan_light *l = fixture_light(p, type, 1);
    const float slope[3] = {-0.48f, -0.8f, 0.36f}; /* casts no shadow into the picture */
    memcpy(l->position, (float[]){0.5f, 2.0f, -0.5f}, sizeof l->position);
    if (type == LIGHT_DIRECTIONAL) memcpy(l->direction, slope, sizeof slope);
    l->cos_inner = type == LIGHT_SPOT ? 0.95f : 1.0f;
    l->cos_outer = 0.5f;
}

static void lay(enum layer layer, struct scene_material *m)
{
    if (layer == COAT) m->clearcoat = 0.8f, m->clearcoat_roughness = 0.2f;
    if (layer == LEAF) m->diffuse_transmission = 0.5f;
    if (layer == FILM) {
        m->iridescence = 1.0f, m->iridescence_ior = 1.8f;
        m->iridescence_nm[0] = m->iridescence_nm[1] = 400.0f;
    }
    if (layer == SHEEN) {
        m->sheen_color[0] = 0.2f, m->sheen_color[1] = 0.9f, m->sheen_color[2] = 0.5f;
        m->sheen_roughness = 0.5f;
    }
}

/* A floor that fills the image, and a wall beside it. */
static struct plan set_up(struct scene_fixture *f, const struct division *d)
{
    struct plan p = floor_plan(f, 20.0f, 24);
    const uint32_t wall = fixture_material(f, 0.7f, 0.4f, 0.2f);
    f->materials[0] = f->materials[coated(f, d->roughness, d->metallic)];
    f->materials[0].transmission = d->transmission;
    lay(d->layer, &f->materials[0]);
    fixture_panel(f, wall, (float[]){-3.0f, 2.0f, 0}, (float[]){0, 0, -6.0f},
                  (float[]){0, 2.0f, 0});
    fixture_panel(f, wall, (float[]){0, -1.0f, 0}, (float[]){20, 0, 0}, (float[]){0, 0, -20});
    if (d->view == GRAZING) {
        memcpy(p.camera.eye, (float[]){0.5f, 0.5f, 2.5f}, sizeof p.camera.eye);
        fixture_look(&p, (float[]){0, -0.2f, -0.9797959f}, (float[]){0, 0.9797959f, -0.2f});
        p.camera.half_width = p.camera.half_height = 0.08f;
    }
    add_light(&p, d->light);
    p.light_planes = 0;
    p.planes = 0;
    fixture_bounces(&p, 4);
    p.planes = 0;
    p.bounces = 2;
    return p;
}

static double path_mean(struct traced *t, const struct plan *p)
{
    const struct rect all = {0, 0, p->width_px, p->height_px};
    double sum = 0;
    for (uint32_t pass = 0; pass < plan_pass_count(p); pass++) {
        struct samples *s = NULL;
        assert_int_equal(trace_tile(t, (struct tile_job){.plan = p, .rect = all}, pass, &s), 0);
        for (uint32_t c = 0; c < 3; c++)
            for (int64_t i = 0; i < rect_area(all); i++)
                sum += (double)samples_f32(s, PLANE_PATH_RADIANCE, c)[i];
        samples_destroy(&s);
    }
    return sum / (double)rect_area(all) / p->paths.spp;
}

static double field_mean(const struct traced *t, const struct plan *p)
{
    double sum = 0;
    const int area = p->width_px * p->height_px;
    for (uint32_t c = 0; c < 3; c++)
        for (int i = 0; i < area; i++) {
            const double albedo = samples_u16(t->samples, PLANE_ALBEDO, c)[i] / 65535.0;
            const double direct = (double)samples_light_irradiance(t->samples, 0)[i] *
                                  (double)p->lights[0].color[c] / PI;
            const double indirect =
                (double)half_to_float(samples_u16(t->samples, PLANE_INDIRECT_MEAN, c)[i]) /
                (double)p->radiance_scale;
            sum += albedo * (direct + indirect);
        }
    return sum / area;
}

/* Returns the share by which fields and paths are off whole paths. */
static double off_by(const struct division *d)
{
    struct scene_fixture *f = fixture_new();
    struct plan entire = set_up(f, d), divided = entire;
    entire.indirect_strata_per_axis = 0;
    entire.paths.spp = 128;
    entire.planes = PLANE_BIT(PATH_RADIANCE);
    divide(&divided, 128);
    divided.light_planes = 1u << LIGHT_PLANE_IRRADIANCE;
    divided.planes |= PLANE_BIT(INDIRECT_MEAN);
    struct traced a = trace_all(f, &entire), b = trace_all(f, &divided);
    const double all = path_mean(&a, &entire), paths = path_mean(&b, &divided),
                 fields = field_mean(&b, &divided);
    assert_true(all > 0 && (fields > 0 || d->metallic == 1.0f));
    if (d->metallic == 1.0f) assert_true(fields == 0);
    traced_fini(&a);
    traced_fini(&b);
    free(f);
    return (fields + paths) / all - 1;
}

/* Every surface in both views, from one by a rectangle and from the other by a light without size;
 * each of these lights in both views, too. */
TEST(fields_and_paths_are_whole_paths)
{
    static const uint32_t sizeless[] = {LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL};
    static const struct {
        float roughness, metallic, transmission;
        enum layer layer;
    } surfaces[] = {{0.05f, 0, 0, BARE},   {0.3f, 0, 0, BARE},    {1, 0, 0, BARE},
                    {0.3f, 0.5f, 0, BARE}, {1, 0.5f, 0, BARE},    {0.3f, 1, 0, BARE},
                    {1, 1, 0, BARE},       {0.3f, 0, 0.5f, BARE}, {0.3f, 0.5f, 0, COAT},
                    {0.5f, 0, 0, SHEEN},   {0.5f, 0, 0, LEAF},    {0.5f, 0.5f, 0, FILM}};
    for (size_t s = 0; s < sizeof surfaces / sizeof surfaces[0]; s++)
        for (size_t v = 0; v < 2; v++) {
            const struct division d = {s % 2 == v ? LIGHT_RECTANGLE : sizeless[s / 2 % 3],
                                       surfaces[s].roughness,
                                       surfaces[s].metallic,
                                       surfaces[s].transmission,
                                       surfaces[s].layer,
                                       v ? GRAZING : FROM_ABOVE};
            const double off = off_by(&d);
            if (fabs(off) > 0.005)
                fail_msg("light %u, roughness %g, metallic %g, transmission %g, layer %d, view "
                         "%d: %g off",
                         d.light, (double)d.roughness, (double)d.metallic, (double)d.transmission,
                         (int)d.layer, (int)d.view, off);
        }
}

/* -- normal maps -- */

/* Gives the floor a normal map that changes nothing. */
static void map_normals(struct scene_fixture *f)
{
    static const uint8_t up[4] = {128, 128, 255, 255};
    f->materials[0].normal_texture.texture = fixture_texture(f, 1, 1, up, 0);
    f->meshes[0].flags |= MESH_HAS_NORMALS | MESH_HAS_TANGENTS;
    for (size_t v = 0; v < 4; v++) {
        memcpy(f->normals + 3 * v, (float[]){0, 1, 0}, 3 * sizeof(float));
        memcpy(f->tangents + 4 * v, (float[]){1, 0, 0, 1}, 4 * sizeof(float));
    }
}

/* Some stratum is hidden from the light. */
static bool is_shaded(const struct traced *t, int32_t i)
{
    return samples_light_visibility(t->samples, 0, 0)[i] != 0xfu;
}

/* To fields the floor is black, but they say what hides the light from it: filters ask neighbours.
 * What paths bring of it is all that whole paths do, bit by bit. */
static void expect_left_to_paths(bool coat, uint32_t left)
{
    struct scene_fixture *f = fixture_new();
    struct plan entire = floor_plan(f, 10.0f, 24);
    if (coat) f->materials[0] = f->materials[coated(f, 0.3f, 0)];
    map_normals(f);
    fixture_panel(f, coated(f, 0.3f, 0), (float[]){2.5f, 0.8f, 0}, (float[]){0.4f, 0, 0},
                  (float[]){0, 0, -0.4f}); /* out of sight */
    fixture_ceiling_light(&entire, 6.0f, 3.0f, 0, 0.5f, 2);
    if (left == DIRECT_LEFT_LISTED)
        entire.environment = (struct plan_environment){
            .kind = ENVIRONMENT_CONSTANT, .radiance = {0.5f, 0.6f, 0.7f}, .power = 1.0f};
    struct plan divided = entire;
    entire.light_planes = 0;
    entire.planes = PLANE_BIT(PATH_RADIANCE);
    entire.paths.spp = 4;
    divide(&divided, 4);
    divided.paths.without_diffuse_direct = left;
    divided.light_planes |= 1u << LIGHT_PLANE_DIFFUSE_WEIGHT;
    struct traced a = trace_all(f, &entire), b = trace_all(f, &divided);
    uint32_t shaded = 0;
    for (int32_t i = 0; i < 24 * 24; i++) {
        assert_int_equal(samples_u32(b.samples, PLANE_ID, 0)[i], 1);
        assert_int_equal(samples_u16(b.samples, PLANE_ALBEDO, 0)[i], 0);
        assert_true(half_to_float(samples_light_weight(b.samples, 0)[i]) == 0.0f);
        assert_true(samples_f32(a.samples, PLANE_PATH_RADIANCE, 0)[i] ==
                    samples_f32(b.samples, PLANE_PATH_RADIANCE, 0)[i]);
        shaded += is_shaded(&b, i);
    }
    assert_true(shaded > 10 && shaded < 24 * 24);
    traced_fini(&a);
    traced_fini(&b);
    free(f);
}

TEST(normal_maps_are_left_to_paths)
{
    for (uint32_t left = DIRECT_LEFT_ALL; left <= DIRECT_LEFT_LISTED; left++) {
        expect_left_to_paths(false, left);
        expect_left_to_paths(true, left);
    }
}

/* -- pixels without other lobes -- */

static struct samples *trace_first(struct traced *t, const struct plan *p, struct rect rect)
{
    struct samples *s = NULL;
    assert_int_equal(trace_tile(t, (struct tile_job){.plan = p, .rect = rect}, 0, &s), 0);
    return s;
}

/* A coated box top on a Lambert floor: pixels away from it trace no path, and nothing of what is
 * sent differs from what all paths bring. */
TEST(paths_that_bring_nothing_are_not_traced)
{
    struct scene_fixture *f = fixture_new();
    struct plan p = floor_plan(f, 10.0f, 48);
    const uint32_t box = coated(f, 0.3f, 0);
    fixture_panel(f, box, (float[]){1, 0.5f, 0}, (float[]){0.5f, 0, 0}, (float[]){0, 0, -0.5f});
    fixture_ceiling_light(&p, 0, 3, 0, 0.5f, 2);
    divide(&p, 4);
    p.planes |= PLANES_RESIDUAL_READ & ~PLANE_BIT(PATH_HALF_INDIRECT);
    struct traced t = trace_all(f, &p);
    const uint64_t traced = count(&t, COUNTER_PATHS), skipped = count(&t, COUNTER_SKIPPED_NO_LOBE);
    assert_int_equal(traced + skipped, 48 * 48 * 4);
    assert_true(traced > 0 && skipped > 2 * traced);
    struct lobe_boxes *boxes = t.scene->lobes;
    assert_int_equal(boxes->count, 1);
    for (int c = 0; c < 3; c++) boxes->box[0].low[c] = -100, boxes->box[0].high[c] = 100;
    struct samples *all = trace_first(&t, &p, (struct rect){0, 0, 48, 48});
    assert_int_equal(count(&t, COUNTER_PATHS) - traced, 48 * 48 * 4);
    assert_memory_equal(all->data, t.samples->data, all->layout.total_bytes);
    double light = 0;
    for (int i = 0; i < 48 * 48; i++) light += (double)samples_f32(all, PLANE_PATH_RADIANCE, 0)[i];
    assert_true(light > 0);
    samples_destroy(&all);
    traced_fini(&t);
    free(f);
}
