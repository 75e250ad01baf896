c     Cohesive user material of LS-DYNA by asperity: in place of umat41c
c     (or, renamed, of umat42c to umat50c). Double precision.
      subroutine umat41c(idpart,cm,lft,llt,fc,dx,dxdt,aux,ek,ifail,
     1                   dt1siz,crv,nhxbwp,cma)
      include 'nlqparm'
      integer idpart,lft,llt,nhxbwp(*)
      real*8 cm(*),fc(nlq,*),dx(nlq,*),dxdt(nlq,*),aux(nlq,*),ek(*)
      real*8 dt1siz(*),crv(*),cma(*)
      logical ifail(*)
c     the library has integers of four bytes
      integer*4 stride,first,last
      stride=nlq
      first=lft
      last=llt
      call asperity_umatc(stride,first,last,cm,fc,dx,aux,ek,dt1siz)
      return
      end
