// embree.hpp - Embree 4 where it is installed, else Embree 3, with one set of calls.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

// What a thread asks an RTCScene with. `coherent`: the rays of a packet go the same way.
class Queries {
  public:
#if RTC_VERSION_MAJOR >= 4
    explicit Queries(bool coherent) {
        rtcInitIntersectArguments(&closest_hit);
        rtcInitOccludedArguments(&any_hit);
        closest_hit.flags = any_hit.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    }
    void closest(RTCScene scene, RTCRayHit &ray) {
        rtcIntersect1(scene, &ray, &closest_hit);
    }
    void closest(RTCScene scene, const int *valid, RTCRayHit16 &rays) {
        rtcIntersect16(valid, scene, &rays, &closest_hit);
    }
    void occluded(RTCScene scene, RTCRay &ray) {
        rtcOccluded1(scene, &ray, &any_hit);
    }
    void occluded(RTCScene scene, const int *valid, RTCRay16 &rays) {
        rtcOccluded16(valid, scene, &rays, &any_hit);
    }

  private:
    RTCIntersectArguments closest_hit;
    RTCOccludedArguments any_hit;
#else
    explicit Queries(bool coherent) {
        rtcInitIntersectContext(&context);
        context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    }
    void closest(RTCScene scene, RTCRayHit &ray) {
        rtcIntersect1(scene, &context, &ray);
    }
    void closest(RTCScene scene, const int *valid, RTCRayHit16 &rays) {
        rtcIntersect16(valid, scene, &context, &rays);
    }
    void occluded(RTCScene scene, RTCRay &ray) {
        rtcOccluded1(scene, &context, &ray);
    }
    void occluded(RTCScene scene, const int *valid, RTCRay16 &rays) {
        rtcOccluded16(valid, scene, &context, &rays);
    }

  private:
    RTCIntersectContext context;
#endif
};
