# The roughconductors of a Mitsuba 0.5 scene as a patch for glb_edit: extras of the model beckmann.
#   awk -f conductors.awk scene.xml > patch.json
function attribute(name,  rest) {
    if (!match($0, name "=\"[^\"]*\"")) return ""
    rest = substr($0, RSTART, RLENGTH)
    sub(/^[^"]*"/, "", rest); sub(/"$/, "", rest)
    return rest
}
BEGIN { printf "{" }
/<bsdf type="roughconductor"/ { inside = 1; id = attribute("id"); scale = "1, 1, 1" }
inside && /name="distribution"/ && attribute("value") != "beckmann" {
    print "no Beckmann facets: " id > "/dev/stderr"; exit failed = 1
}
inside && /name="extEta"/ && attribute("value") != 1 {
    print "not in vacuum: " id > "/dev/stderr"; exit failed = 1
}
inside && /name="alpha"/ { alpha = attribute("value") }
inside && /name="eta"/ { eta = attribute("value") }
inside && /name="k"/ { k = attribute("value") }
inside && /name="specularReflectance"/ { scale = attribute("value") }
inside && /<\/bsdf>/ {
    printf "%s\n\"%s\": {\"extras\": {\"shearwater\": {\"model\": \"beckmann\", \"alpha\": %s, ", comma, id, alpha
    printf "\"eta\": [%s], \"k\": [%s], \"specular\": [%s]}}}", eta, k, scale
    comma = ","; inside = 0
}
END { if (failed) exit 1; print "\n}" }
