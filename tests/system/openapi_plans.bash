# What the server says of a job before a ray is traced; openapi.sh reads it, with its assets on the server.
check_plan() { # check_plan WHAT DOCUMENT JQ-FILTER: of the plan
    check "$1" answers 200 POST /v1/jobs "${json[@]}" -d "$2" "/v1/jobs?dry_run=1"
    check "... and the plan says so" jq -e ".plan | $3" "$tmp/body"
}
check_fault() { # check_fault WHAT DOCUMENT POINTER WORDS
    check "$1" answers 422 POST /v1/jobs "${json[@]}" -d "$2" "/v1/jobs?dry_run=1"
    check "... at $3" jq -e --arg words "$4" ".pointer == \"$3\" and (.detail | contains(\$words))" "$tmp/body"
}
check_plan "auto is light fields in a Lambert box" "{$scene_member}" \
    '.integrator == "light_field" and (.skipped | any(.what == "paths"))'
check_plan "auto filters its lamp" "{$scene_member}" \
    '.filter == "sheared" and (.filter_why | startswith("9 samples a light")) and
     .light_planes == ["visibility", "slopes"] and (.skipped | any(.what == "plane irradiance"))'
check_plan "it says which filter cleans which light" "{$scene_member, \"effects\": {\"indirect_bounces\": 1}}" \
    '.light_filters == [{light: "rectangle", lobes: "diffuse", by: "light_field", filter: "sheared"},
                        {light: "indirect", lobes: "diffuse", by: "light_field", filter: "constant"}]'
check_plan "light without area is not filtered" "{\"scene\": {\"asset\": \"$asset\", \"lights\": false},
    \"lights\": [{\"type\": \"point\", \"position\": [0, 1, 0], \"intensity\": [1, 1, 1]}], \"filter\": {\"method\": \"sheared\"}}" \
    '.filter == "none" and .light_planes == ["irradiance"] and
     (.warnings | any(startswith("filter.method is sheared, but shadows are not filtered: no light has area")))'
check_plan "auto filters its bounces" "{$scene_member, \"effects\": {\"indirect_bounces\": 6}}" \
    '.integrator == "light_field" and .indirect_filter == "constant" and
     .indirect_filter_why == "9 bounce rays: weighted means need the fewest" and
     (.planes | index("bounce_distance_min")) and .samples.indirect == 9'
check_plan "shadows beside paths are not filtered" "{\"scene\": {\"asset\": \"$asset\", \"lights\": false}, \"environment\": {\"asset\": \"$map\"}, \"filter\": {\"method\": \"axis_aligned\"}}" \
    '.integrator == "paths" and .filter == "none" and (.filter_why | startswith("the residual filter cleans whole paths")) and
     (.warnings | any(startswith("filter.method is axis_aligned, but shadows are not filtered")))'
check_plan "an environment leaves a lamp to fields" "{$scene_member, \"environment\": {\"asset\": \"$map\"}}" \
    '.integrator == "paths_and_light_field" and .filter == "sheared" and
     (.light_filters | any(. == {light: "rectangle", lobes: "diffuse", by: "light_field", filter: "sheared"})
                       and any(. == {light: "environment", lobes: "diffuse", by: "paths", filter: "halves"}))'
check_plan "an environment asks for paths" "{\"scene\": {\"asset\": \"$asset\", \"lights\": false}, \"environment\": {\"asset\": \"$map\"}}" \
    '.integrator == "paths" and .environment.type == "map" and (.effects | index("environment"))
     and (.skipped | any(.what == "light fields of lights" and .why == "there is an environment"))
     and .residual_filter == "halves" and (.planes | index("path_radiance") and index("path_half_scattered"))'
check_plan "fields of indirect light run beside paths by name" "{$scene_member, \"environment\": {\"asset\": \"$map\"}, \"filter\": {\"indirect\": \"linear\"}}" \
    '.integrator == "paths_and_light_field" and .indirect_filter == "linear" and (.planes | index("path_radiance") and index("indirect_mean"))'
check_plan "a lens has a light field of its own" "{$scene_member, \"lens\": {\"aperture_radius\": 0.1, \"focus_distance\": 5},
    \"filter\": {\"indirect\": \"linear\"}, \"sampling\": {\"lens_spp\": 16}}" \
    '.integrator == "lens_field" and .lens_filter == "sheared" and .samples.lens == 16 and .lens_relight == "diffuse"
     and .indirect_filter == "linear"
     and (.planes | index("lens_radiance") and index("lens_slope") and index("lens_own_light") and (index("path_radiance") | not))
     and (.warnings | any(contains("not filtered")) | not)'
check_plan "layers of paths ask for paths alone, with a lens" "{$scene_member, \"lens\": {\"aperture_radius\": 0.1, \"focus_distance\": 5},
    \"layers\": [\"beauty\", \"direct\"], \"filter\": {\"indirect\": \"linear\", \"lens\": \"sheared\"}}" \
    '.integrator == "paths" and .lens_filter == "none"
     and (.skipped | any(.what == "light fields" and .why == "with a lens only paths give the layer direct"))
     and (.warnings | any(startswith("filter.lens is sheared, but no lens samples are filtered")))
     and (.warnings | any(startswith("filter.indirect is linear, but indirect light is not filtered")))'
check_plan "occlusion is a light field of its own" "{$scene_member, \"effects\": {\"indirect_bounces\": 0, \"ambient_occlusion\": {\"distance\": 1}},
    \"layers\": [\"occlusion\"], \"sampling\": {\"indirect_spp\": 64}}" \
    '.integrator == "light_field" and (.planes | index("ambient_visibility")) and (.planes | index("indirect_mean") | not) and
     .indirect_filter == "linear" and .samples.indirect == 64'
check_plan "adaptive rates begin with 16 rays" "{$scene_member, \"filter\": {\"indirect\": \"adaptive\"}}" \
    '.indirect_filter == "adaptive" and .samples.indirect == 16 and .samples.indirect_most == 100 and (.planes | index("bounce_distance_max"))'
check_plan "adaptive rates leave nothing to light fields before a lens" "{$scene_member, \"lens\": {\"aperture_radius\": 0.1, \"focus_distance\": 5},
    \"filter\": {\"indirect\": \"adaptive\", \"glossy\": \"virtual_hit\"}}" \
    '.integrator == "lens_field" and .lens_relight == "own" and .indirect_filter == "none" and .glossy_filter == "none" and (.samples | has("indirect_most") | not)
     and (.planes | any(startswith("glossy_") or startswith("bounce_distance")) | not)
     and (.warnings | any(startswith("filter.indirect is adaptive")) and any(startswith("filter.glossy is virtual_hit")))'
check_plan "none is paths" "{$scene_member, \"filter\": {\"method\": \"none\"}, \"sampling\": {\"spp\": 100}}" \
    '.integrator == "paths" and .samples.paths == 100 and (.planes | index("path_radiance"))'
check_fault "a scene is no environment" "{$scene_member, \"environment\": {\"asset\": \"$asset\"}}" \
    /environment/asset "a scene, no environment map"
check_fault "an environment is no scene" "{\"scene\": {\"asset\": \"$map\"}}" \
    /scene/asset "an environment map, no scene"
check_fault "an open lens has to be focused" "{$scene_member, \"lens\": {\"aperture_radius\": 1}}" \
    /lens/focus_distance "has to be focused"
check_fault "ambient occlusion needs a distance" "{$scene_member, \"layers\": [\"occlusion\"]}" \
    /effects/ambient_occlusion distance
check_fault "no filter has no width" "{$scene_member, \"layers\": [\"filter_width\"], \"filter\": {\"method\": \"none\"}}" \
    /filter/method "filters nothing"
check_fault "adaptive sampling knows no error" "{$scene_member, \"filter\": {\"indirect\": \"adaptive\"}, \"sampling\": {\"target_error\": 0.1}}" \
    /filter/indirect "does not know its error"
check_fault "adaptive sampling does not know its error" \
    "{$scene_member, \"filter\": {\"indirect\": \"adaptive\"}, \"layers\": [\"beauty\", \"error\"]}" \
    /filter/indirect "does not know its error"
check_fault "a target is the picture's" "{$scene_member, \"sampling\": {\"target_error\": 0.1}, \"layers\": [\"depth\"]}" \
    /layers "target_error is of the layer beauty"
