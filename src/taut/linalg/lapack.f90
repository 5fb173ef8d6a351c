!> Explicit interfaces of the LAPACK and BLAS routines that taut calls, in one place.
!!
!! Reference: Anderson et al., LAPACK Users' Guide, 3rd ed., SIAM 1999. Argument meanings are those of LAPACK's own
!! documentation.
module taut_linalg_lapack
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: dpotrf, dpotrs, dpstrf, dgelsd, dgemm, dtrtrs, dgeqp3, dorgqr, dgetrf, dgetrs, dgecon, dgtsv, dsygv, dgeev, &
             dgesvd, dgbtrf, dgbtrs, zgbtrf, zgbtrs, zgetrf, zgetrs

   interface
      !> Cholesky factorization of a symmetric positive definite matrix.
      subroutine dpotrf(uplo, n, a, lda, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: uplo
         integer, intent(in) :: n, lda
         real(wp), intent(inout) :: a(lda, *)
         integer, intent(out) :: info
      end subroutine dpotrf

      !> Solves A X = B with the factor of `dpotrf`.
      subroutine dpotrs(uplo, n, nrhs, a, lda, b, ldb, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: uplo
         integer, intent(in) :: n, nrhs, lda, ldb
         real(wp), intent(in) :: a(lda, *)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dpotrs

      !> Cholesky factorization with pivoting of a symmetric positive semi-definite matrix.
      subroutine dpstrf(uplo, n, a, lda, piv, rank, tol, work, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: uplo
         integer, intent(in) :: n, lda
         real(wp), intent(inout) :: a(lda, *), work(*)
         integer, intent(inout) :: piv(*)
         integer, intent(out) :: rank, info
         real(wp), intent(in) :: tol
      end subroutine dpstrf

      !> Minimum-norm least-squares solution by the singular value decomposition. LDB must reach max(m, n).
      subroutine dgelsd(m, n, nrhs, a, lda, b, ldb, s, rcond, rank, work, lwork, iwork, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
         real(wp), intent(inout) :: a(lda, *), b(ldb, *), s(*), work(*)
         real(wp), intent(in) :: rcond
         integer, intent(out) :: rank, info
         integer, intent(inout) :: iwork(*)
      end subroutine dgelsd

      !> C := alpha op(A) op(B) + beta C.
      subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: transa, transb
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(wp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
         real(wp), intent(inout) :: c(ldc, *)
      end subroutine dgemm

      !> Solves op(A) X = B with A triangular.
      subroutine dtrtrs(uplo, trans, diag, n, nrhs, a, lda, b, ldb, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: uplo, trans, diag
         integer, intent(in) :: n, nrhs, lda, ldb
         real(wp), intent(in) :: a(lda, *)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dtrtrs

      !> Factorization Q R of a matrix with its columns exchanged so that the diagonal of R decreases.
      subroutine dgeqp3(m, n, a, lda, jpvt, tau, work, lwork, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, lda, lwork
         real(wp), intent(inout) :: a(lda, *), tau(*), work(*)
         integer, intent(inout) :: jpvt(*)
         integer, intent(out) :: info
      end subroutine dgeqp3

      !> Forms the first n columns of the Q of `dgeqp3`.
      subroutine dorgqr(m, n, k, a, lda, tau, work, lwork, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, k, lda, lwork
         real(wp), intent(inout) :: a(lda, *), work(*)
         real(wp), intent(in) :: tau(*)
         integer, intent(out) :: info
      end subroutine dorgqr

      !> Factorization L U with exchanged rows.
      subroutine dgetrf(m, n, a, lda, ipiv, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         real(wp), intent(inout) :: a(lda, *)
         integer, intent(out) :: ipiv(*), info
      end subroutine dgetrf

      !> Solves op(A) X = B with the factors of `dgetrf`.
      subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         real(wp), intent(in) :: a(lda, *)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dgetrs

      !> Estimates the reciprocal condition number from the factors of `dgetrf`.
      subroutine dgecon(norm, n, a, lda, anorm, rcond, work, iwork, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: norm
         integer, intent(in) :: n, lda
         real(wp), intent(in) :: a(lda, *), anorm
         real(wp), intent(out) :: rcond
         real(wp), intent(inout) :: work(*)
         integer, intent(inout) :: iwork(*)
         integer, intent(out) :: info
      end subroutine dgecon

      !> Solves A X = B, A tridiagonal.
      subroutine dgtsv(n, nrhs, dl, d, du, b, ldb, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: n, nrhs, ldb
         real(wp), intent(inout) :: dl(*), d(*), du(*), b(ldb, *)
         integer, intent(out) :: info
      end subroutine dgtsv

      !> Eigenvalues and eigenvectors of A x = w B x, A symmetric, B symmetric positive definite.
      subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: jobz, uplo
         integer, intent(in) :: itype, n, lda, ldb, lwork
         real(wp), intent(inout) :: a(lda, *), b(ldb, *), w(*), work(*)
         integer, intent(out) :: info
      end subroutine dsygv

      !> Eigenvalues and eigenvectors of any matrix.
      subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(wp), intent(inout) :: a(lda, *), wr(*), wi(*), vl(ldvl, *), vr(ldvr, *), work(*)
         integer, intent(out) :: info
      end subroutine dgeev

      !> Singular values and vectors.
      subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: jobu, jobvt
         integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
         real(wp), intent(inout) :: a(lda, *), s(*), u(ldu, *), vt(ldvt, *), work(*)
         integer, intent(out) :: info
      end subroutine dgesvd

      !> LU factorization with row interchanges of a band matrix: kl and ku diagonals below and above the main one.
      subroutine dgbtrf(m, n, kl, ku, ab, ldab, ipiv, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, kl, ku, ldab
         real(wp), intent(inout) :: ab(ldab, *)
         integer, intent(inout) :: ipiv(*)
         integer, intent(out) :: info
      end subroutine dgbtrf

      !> Solves A X = B with the factors of `dgbtrf`.
      subroutine dgbtrs(trans, n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb, ipiv(*)
         real(wp), intent(in) :: ab(ldab, *)
         real(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine dgbtrs

      !> LU factorization with row interchanges of a complex band matrix.
      subroutine zgbtrf(m, n, kl, ku, ab, ldab, ipiv, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, kl, ku, ldab
         complex(wp), intent(inout) :: ab(ldab, *)
         integer, intent(inout) :: ipiv(*)
         integer, intent(out) :: info
      end subroutine zgbtrf

      !> Solves A X = B with the factors of `zgbtrf`.
      subroutine zgbtrs(trans, n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb, ipiv(*)
         complex(wp), intent(in) :: ab(ldab, *)
         complex(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine zgbtrs

      !> LU factorization of a complex matrix.
      subroutine zgetrf(m, n, a, lda, ipiv, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: m, n, lda
         complex(wp), intent(inout) :: a(lda, *)
         integer, intent(inout) :: ipiv(*)
         integer, intent(out) :: info
      end subroutine zgetrf

      !> Solves A X = B with the factors of `zgetrf`.
      subroutine zgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         implicit none (type, external)
         character, intent(in) :: trans
         integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
         complex(wp), intent(in) :: a(lda, *)
         complex(wp), intent(inout) :: b(ldb, *)
         integer, intent(out) :: info
      end subroutine zgetrs
   end interface

end module taut_linalg_lapack
