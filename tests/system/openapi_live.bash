# Feeds of jobs, and steering them; openapi.sh reads it, with a job that runs.

# Feeds. That of a running job has no end: curl gives up after two seconds, and that is fine.
p='/v1/jobs/{id}/events'
try 200 GET $p "/v1/jobs/$id/events"
sed -n 's/^data: //p' "$tmp/body" | head -n 1 >"$tmp/snapshot"
check "its snapshot is a job's status" contract schema JobStatus "$tmp/snapshot"
try 404 GET $p "/v1/jobs/$none/events"
wait_s=3 try 200 GET $p "/v1/jobs/$running/events" 2>/dev/null
# event_fits NAME SCHEMA: the last event of the name, if one came
event_fits() {
    awk -v name="$1" '/^event: /{e = $2} /^data: / && e == name {print substr($0, 7)}' "$tmp/body" | tail -n 1 >"$tmp/event"
    [ -s "$tmp/event" ] && contract schema "$2" "$tmp/event"
}
check "a progress event is as documented" event_fits progress Progress
check "a tile event is as documented" event_fits tile TileEvent
p='/v1/jobs/{id}/pixels'
try 200 GET $p "/v1/jobs/$id/pixels?layer=depth"
try 404 GET $p "/v1/jobs/$id/pixels?layer=normal"
try 200 GET $p "/v1/jobs/$id/pixels?layer=depth&format=float"
try 400 GET $p "/v1/jobs/$id/pixels?format=double"
try 400 GET $p "/v1/jobs/$id/pixels?after=soon"
try 200 GET $p "/v1/jobs/$id/pixels?frame=1"
try 409 GET $p "/v1/jobs/$id/pixels?frame=77"
try 400 GET $p "/v1/jobs/$id/pixels?frame=last"
wait_s=3 try 200 GET $p "/v1/jobs/$running/pixels?after=0" 2>/dev/null
wait_s=3 try 200 GET $p "/v1/jobs/$running/pixels" 2>/dev/null
check "the feed begins with the image's size" bash -c "
    [ \"\$(od -An -tu4 -j8 -N16 '$tmp/body' | tr -s ' ')\" = ' 1536 1536 0 0' ] && [ \"\$(head -c 4 '$tmp/body')\" = SWPX ]"

# Steering, on a job that is paused and so keeps its tag.
p='/v1/jobs/{id}'
try 200 PATCH $p "${json[@]}" -d '{"paused": true, "priority": -2}' "/v1/jobs/$running"
check "the answer shows it" jq -e '.paused and .priority == -2 and .region == null and .near == null' "$tmp/body"
steers() { # steers STATUS DOCUMENT: schema and server agree
    printf '%s' "$2" >"$tmp/document"
    local fits=200
    contract schema Steering "$tmp/document" >"$tmp/misfits" || fits=422
    [ $fits = "$1" ] || { echo "the schema says $fits"; cat "$tmp/misfits"; return 1; }
    answers "$1" PATCH $p "${json[@]}" --data-binary @"$tmp/document" "/v1/jobs/$running"
}
for document in '{"priority": -100}' '{"priority": 100, "paused": true}' '{"region": null}' '{"near": null}' \
    '{"region": {"x": 0, "y": 0, "width": 1536, "height": 1536}, "near": {"x": 1535, "y": 0}}'; do
    check "steered by $document" steers 200 "$document"
done
for document in '{}' '[]' '{"priority": 101}' '{"priority": "1"}' '{"paused": null}' '{"fast": true}' \
    '{"region": {"x": 0, "y": 0, "width": 0, "height": 1}}' '{"region": {"x": 0, "y": 0, "width": 1}}' '{"near": {"x": -1, "y": 0}}' \
    '{"near": {"x": 0, "y": 0, "z": 0}}'; do
    check "not steered by $document" steers 422 "$document"
done
# Marks, on the same.
marks() { # marks STATUS DOCUMENT: schema and server agree
    printf '%s' "$2" >"$tmp/document"
    local fits=200
    contract schema JobMarks "$tmp/document" >"$tmp/misfits" || fits=422
    [ $fits = "$1" ] || { echo "the schema says $fits"; cat "$tmp/misfits"; return 1; }
    answers "$1" PATCH $p "${json[@]}" --data-binary @"$tmp/document" "/v1/jobs/$running"
}
for document in '{"name": null}' '{"comment": "two\nlines", "labels": ["b", "a:1"]}' "{\"name\": \"$(printf 'ä%.0s' {1..200})\"}" '{"labels": []}'; do
    check "marked by ${document:0:60}" marks 200 "$document"
done
for document in '{"name": ""}' '{"name": "two\nlines"}' '{"name": 1}' '{"labels": null}' '{"labels": ["a", "a"]}' '{"labels": ["a,b"]}' \
    '{"comment": "\u0007"}' '{"name": "a", "webhook": null}' '{"labels": [], "priority": 1}' "{\"name\": \"$(printf 'ä%.0s' {1..201})\"}"; do
    check "not marked by ${document:0:60}" marks 422 "$document"
done
try 200 PATCH $p "${json[@]}" -d '{"name": "Ended"}' "/v1/jobs/$id"
try 412 PATCH $p "${json[@]}" -H 'If-Match: "0"' -d '{"name": "Ended"}' "/v1/jobs/$id"
try 404 PATCH $p "${json[@]}" -d '{"name": "Nobody"}' "/v1/jobs/$none"
check "a region beyond the picture" answers 422 PATCH $p "${json[@]}" -d '{"region": {"x": 1500, "y": 0, "width": 37, "height": 1}}' "/v1/jobs/$running"
check "... is refused at its width" jq -e '.pointer == "/region/width" and (.detail | contains("1537"))' "$tmp/body"
try 400 PATCH $p "${json[@]}" -d '{"paused"' "/v1/jobs/$running"
try 404 PATCH $p "${json[@]}" -d '{"paused": true}' "/v1/jobs/$none"
try 409 PATCH $p "${json[@]}" -d '{"paused": true}' "/v1/jobs/$id"
try 412 PATCH $p "${json[@]}" -H 'If-Match: "0"' -d '{"paused": true}' "/v1/jobs/$running"
try 413 PATCH $p "${json[@]}" -H 'Content-Length: 1048577' -H 'Expect: 100-continue' -d '{}' "/v1/jobs/$running"
try 415 PATCH $p -d '{}' "/v1/jobs/$running"
wait_s=2 try 200 GET '/v1/jobs/{id}/events' "/v1/jobs/$running/events" 2>/dev/null
sed -n 's/^data: //p' "$tmp/body" | head -n 1 >"$tmp/snapshot"
check "a paused job's snapshot is a job's status" contract schema JobStatus "$tmp/snapshot"
